// The contract as a page: the calls of openapi.json by topic, then the types that they take and give.

import { html, table } from "./dom.js";

/** The address of a type on this page. */
const anchor = (name) => `type-${name}`;
const code = (words) => html("code", {}, words);
const separated = (parts, words) => parts.flatMap((part, i) => (i ? [words, part] : [part]));

/** A text of the contract: what stands between backticks is code. */
function words(text) {
  const parts = (text ?? "").split("`");
  return html("span", { class: "words" }, parts.map((part, i) => (i % 2 ? code(part) : part)));
}

/** What a value is, in a few words, with links to types that have a name. */
function kind(schema) {
  if (schema.$ref?.startsWith("#")) {
    const name = schema.$ref.split("/").pop();
    return html("a", { href: `#${anchor(name)}` }, name);
  }
  if (schema.$ref) return html("a", { href: `../${schema.$ref}` }, schema.$ref);
  const several = schema.oneOf ?? schema.anyOf;
  if (several) return html("span", {}, separated(several.map(kind), " or "));
  if (schema.allOf) return html("span", {}, separated(schema.allOf.map(kind), " and "));
  if (schema.enum) return html("span", {}, separated(schema.enum.map((value) => code(JSON.stringify(value))), " | "));
  const types = [schema.type ?? "anything"].flat();
  return html("span", {}, separated(types.map((type) => ofType(type, schema)), " or "));
}

function ofType(type, schema) {
  if (type === "array" && schema.items) return html("span", {}, "list of ", kind(schema.items));
  if (type === "object" && schema.properties) return html("span", {}, "object with ", Object.keys(schema.properties).join(", "));
  return schema.format === "uuid" ? "UUID" : type;
}

/** The members of an object, or nothing. */
function members(schema, caption) {
  const rows = Object.entries(schema.properties ?? {}).map(([name, member]) => [
    code(name),
    kind(member),
    schema.required?.includes(name) ? "required" : "",
    words(member.description),
  ]);
  return rows.length ? table(caption, ["member", "type", "needed", "what it is"], rows) : null;
}

/** A type: its members, and those of each of its variants. */
function typeDetails(name, schema) {
  const variants = schema.oneOf ?? schema.anyOf ?? schema.allOf ?? [];
  const inside = [members(schema, `Members of ${name}`), ...variants.map((v) => members(v, v.description ?? `Members of a variant of ${name}`))];
  const isPlain = !inside.some(Boolean);
  return html(
    "details",
    { class: "type", id: anchor(name) },
    html("summary", {}, html("b", {}, name), " ", words(schema.description)),
    isPlain && html("p", {}, kind(schema)),
    inside,
  );
}

/** What a body holds: media types, each with its type. */
function content(body) {
  const kinds = Object.entries(body?.content ?? {});
  return html("span", {}, separated(kinds.map(([media, { schema }]) => [code(media), schema && [": ", kind(schema)]]), "; "));
}

function callDetails(path, method, call) {
  const parameters = (call.parameters ?? []).map((p) => [code(p.name), p.in, kind(p.schema ?? {}), p.required ? "required" : "", words(p.description)]);
  const answers = Object.entries(call.responses).map(([status, answer]) => [
    status,
    words(answer.description),
    content(answer),
    separated(Object.entries(answer.headers ?? {}).map(([name, h]) => html("span", { title: h.description }, code(name))), ", "),
  ]);
  return html(
    "details",
    { class: "call", id: call.operationId },
    html("summary", {}, html("span", { class: "badge busy method" }, method.toUpperCase()), code(path), html("span", {}, call.summary)),
    call.description && html("p", {}, words(call.description)),
    parameters.length > 0 && table("Parameters", ["name", "in", "type", "needed", "what it is"], parameters),
    call.requestBody && html("p", {}, html("b", {}, "Body: "), content(call.requestBody)),
    table("Answers", ["status", "meaning", "body", "headers"], answers),
  );
}

function page(contract) {
  const calls = Object.entries(contract.paths).flatMap(([path, methods]) =>
    Object.entries(methods).map(([method, call]) => ({ topic: call.tags?.[0], element: callDetails(path, method, call) })),
  );
  const topics = contract.tags.map(({ name, description }) =>
    html("section", { class: "panel" }, html("h2", {}, `${name}: ${description}`), calls.filter((call) => call.topic === name).map((call) => call.element)),
  );
  const types = Object.entries(contract.components.schemas).map(([name, schema]) => typeDetails(name, schema));
  return [
    html("div", { class: "title" }, html("h1", {}, `${contract.info.title} ${contract.info.version}: API`)),
    html("p", {}, words(contract.info.description)),
    html("p", {}, "Where the service was started with tokens, a call carries one: ", code("Authorization: Bearer …"), "."),
    topics,
    html("section", { class: "panel" }, html("h2", {}, "Types"), types),
  ];
}

/** Opens what the address names: a link to a type would show a closed line. */
function openTarget() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (target?.tagName !== "DETAILS") return;
  target.open = true;
  target.scrollIntoView();
}

const main = document.getElementById("main");
try {
  const answer = await fetch("../openapi.json");
  if (!answer.ok) throw new Error(`the service answered ${answer.status}`);
  main.replaceChildren(...page(await answer.json()).flat());
  openTarget();
  addEventListener("hashchange", openTarget);
} catch (error) {
  main.replaceChildren(html("p", { class: "alert" }, `The contract could not be shown: ${error.message}.`));
}
