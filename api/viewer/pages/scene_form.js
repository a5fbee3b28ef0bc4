// A form of a scene document by what it is about: projectile, target, impact, accuracy, what is recorded; each input has a JSON pointer.

import { html } from "../dom.js";
import { choicesOf, isAlongAxes, kindOf } from "../scene/choices.js";
import { inForm, isNumber, isOfComputer, meant, shown, words } from "../scene/scene_units.js";
import { plainly } from "../summary/plain_terms.js";

/** What of a projectile is about the impact: where it comes from and how fast. */
const OF_IMPACT = ["velocity_m_per_s", "spin_rad_per_s", "placement"];
/** Members of a scene by the section that they belong to; all others are in the last. */
const OF_SCENE = new Map([
  ...["contact", "planes", "gravity_m_per_s2", "preload", "dynamic_relaxation"].map((key) => [key, "Impact"]),
  ...["accuracy", "solver", "integrator", "end_time_s"].map((key) => [key, "Accuracy and time"]),
  ...["record", "measures"].map((key) => [key, "What is recorded"]),
]);
const SECTIONS = ["Projectile", "Target", "Impact", "Accuracy and time", "What is recorded", "Name and the rest"];
/** Sections that are open at first. */
const OPEN = ["Projectile", "Target", "Impact"];
/** Parts that say how large something is: open, too. */
const SHAPES = /\/(mesh|generator|rigid|shape|layers)$/;

const escaped = (key) => String(key).replaceAll("~", "~0").replaceAll("/", "~1");
const isVector = (key, value) => Array.isArray(value) && value.length === 3 && isAlongAxes(key) && value.every((c) => typeof c === "number");
const isList = (value) => Array.isArray(value) && value.length > 0 && value.every((c) => typeof c === "number");
const isLeaf = (value) => value === null || typeof value !== "object" || isList(value);

/** The members of a scene document by section: [key, value, owner, pointer]. */
function sectionsOf(scene) {
  const sections = new Map(SECTIONS.map((name) => [name, []]));
  for (const [key, value] of Object.entries(scene)) {
    if (key === "bodies" && Array.isArray(value)) continue;
    sections.get(OF_SCENE.get(key) ?? SECTIONS.at(-1)).push([key, value, scene, `/${escaped(key)}`]);
  }
  (Array.isArray(scene.bodies) ? scene.bodies : []).forEach((body, i) => {
    const isProjectile = body?.role === "projectile";
    for (const [key, value] of Object.entries(body ?? {})) {
      const section = isProjectile ? (OF_IMPACT.includes(key) ? "Impact" : "Projectile") : "Target";
      sections.get(section).push([key, value, body, `/bodies/${i}/${escaped(key)}`]);
    }
  });
  return sections;
}

export class SceneForm {
  element = html("div", { class: "scene-form" });
  #inputs = new Map();
  #groups = new Map();
  #onChange;
  #document = {};
  #opened = new Map();

  /** `onChange()` after the document that was given to `show` has been changed by an input. */
  constructor(onChange) {
    this.#onChange = onChange;
  }

  show(document) {
    this.#document = document;
    this.#inputs.clear();
    this.#groups.clear();
    const sections = [...sectionsOf(document)].filter(([, members]) => members.length);
    this.element.replaceChildren(...sections.map(([name, members]) => {
      const isOpen = this.#opened.get(name) ?? OPEN.includes(name);
      const section = html("details", { class: "form-section", open: isOpen, ontoggle: () => this.#opened.set(name, section.open) }, html("summary", {}, name), this.#members(members));
      // What is wrong with a body as a whole is said where most of it is.
      for (const [, , , pointer] of members) {
        const [body] = pointer.match(/^\/bodies\/\d+/) ?? [""];
        if (name !== "Impact") this.#groups.set(body, section);
      }
      return section;
    }));
  }

  /** Inputs of the members that are simple, then parts: [key, value, owner, pointer]. */
  #members(members) {
    const isSimple = ([, value]) => isLeaf(value);
    const simple = members.filter(isSimple).map(([key, value, owner, pointer]) => this.#field(owner, key, value, pointer));
    const parts = members.filter((member) => !isSimple(member)).map(([key, value, , pointer]) => this.#part(key, value, pointer));
    return [...(simple.length ? [html("div", { class: "form-grid" }, simple)] : []), ...parts];
  }

  #contents(value, pointer) {
    return this.#members(Object.entries(value).map(([key, inner]) => [key, inner, value, `${pointer}/${escaped(key)}`]));
  }

  #part(key, value, pointer) {
    const title = value.name ?? value.part ?? (/^\d+$/.test(key) ? `number ${Number(key) + 1}` : words(key));
    const isOpen = this.#opened.get(pointer) ?? SHAPES.test(pointer);
    const part = html("details", { open: isOpen, ontoggle: () => this.#opened.set(pointer, part.open) }, html("summary", { title: key }, title), this.#contents(value, pointer));
    this.#groups.set(pointer, part);
    return part;
  }

  #field(owner, key, value, pointer) {
    // The name in the document is for those who write one.
    const label = html("span", { title: key }, /^\d+$/.test(key) ? `number ${Number(key) + 1}` : words(key));
    if (isVector(keyOf(pointer), value)) {
      const inputs = value.map((component, i) => this.#input(value, i, component, { key, pointer: `${pointer}/${i}`, name: `${words(key)}, ${"xyz"[i]}` }));
      const named = inputs.map((input, i) => html("span", {}, html("span", { "aria-hidden": "true" }, "xyz"[i]), input));
      const group = html("div", { class: "field wide", role: "group", "aria-label": words(key) }, label, html("span", { class: "vector along" }, named));
      this.#inputs.set(pointer, inputs[0]);
      return group;
    }
    const kind = kindOf(key, value);
    // What other members depend on is changed with them, in the document.
    if (kind) {
      const output = html("output", { tabindex: "-1", title: `${value}: another is set in the JSON, with what it needs`, "data-pointer": pointer, "data-kind": "string", "data-word": value }, kind);
      this.#inputs.set(pointer, output);
      return html("div", { class: "field" }, label, output);
    }
    const choices = typeof value === "string" && choicesOf(keyOf(pointer), value);
    const simple = () => (isList(value) ? this.#listInput(owner, key, value, pointer) : this.#input(owner, key, value, { key, pointer }));
    const input = choices ? this.#choice(owner, key, choices, pointer) : simple();
    const longest = choices ? Math.max(...choices.map(([, name]) => name.length)) : typeof value === "string" ? value.length : 0;
    const isWide = isList(value) || longest > 24;
    return html("label", { class: isWide ? "field wide" : "field" }, label, input);
  }

  /** Numbers in one line, with spaces between them. */
  #listInput(owner, key, value, pointer) {
    const take = () => {
      owner[key] = input.value.trim().split(/[\s;]+/).map((text) => meant(key, text));
      this.#onChange();
    };
    const input = html("input", { type: "text", value: value.map((one) => shown(key, one)).join(" "), "data-pointer": pointer, oninput: take });
    this.#inputs.set(pointer, input);
    return input;
  }

  /** A choice among words of the document, in plain words. */
  #choice(owner, at, options, pointer) {
    const take = () => {
      owner[at] = choice.value;
      // The role of a body says to which section it belongs.
      if (at === "role") {
        this.show(this.#document);
        this.#inputs.get(pointer)?.focus();
      }
      this.#onChange();
    };
    const choice = html("select", { "data-pointer": pointer, "data-kind": "string", onchange: take }, options.map(([word, words]) => html("option", { value: word, selected: word === owner[at] }, words)));
    this.#inputs.set(pointer, choice);
    return choice;
  }

  /** An input of the member `at` of its owner; `key` has the unit, which of a vector is that of the whole. */
  #input(owner, at, value, { key, pointer, name }) {
    const take = () => {
      owner[at] = typeof value === "number" ? meant(key, input.value) : typeof value === "boolean" ? input.checked : input.value;
      this.#onChange();
    };
    const kind = { number: { inputmode: "decimal", type: "text", value: shown(key, value) }, boolean: { type: "checkbox", checked: value === true } };
    const attributes = kind[typeof value] ?? { type: "text", value: value ?? "" };
    const input = html("input", { ...attributes, "aria-label": name, "data-pointer": pointer, "data-kind": typeof value, oninput: take });
    this.#inputs.set(pointer, input);
    return input;
  }

  /** Shows what is wrong, each beside its input, or beside the part that holds its place. */
  showProblems(problems) {
    this.element.querySelectorAll(".field-error").forEach((error) => error.remove());
    this.element.querySelectorAll("[aria-invalid]").forEach((input) => input.removeAttribute("aria-invalid"));
    for (const problem of this.withTexts(problems)) {
      const place = this.#placeOf(problem);
      const message = html("span", { class: "field-error" }, plainly(problemWords(problem)));
      if (place?.input) {
        for (const input of place.all) input.setAttribute("aria-invalid", "true");
        (place.input.closest(".field") ?? place.input).append(message);
      } else place?.group?.firstElementChild.after(message);
      for (let part = (place?.input ?? place?.group)?.closest("details"); part; part = part.parentElement.closest("details")) part.open = true;
    }
  }

  /** Problems with one for each field that has a text in place of a number: the service may name only the part that it is in. */
  withTexts(problems) {
    const texts = [...this.#inputs].filter(([pointer, input]) => input.dataset.pointer === pointer && input.dataset.kind === "number" && !isNumber(input.value)).map(([pointer]) => pointer);
    const isOfText = ({ pointer, code }) => texts.some((text) => text === pointer || (code === "wrong_structure" && text.startsWith(`${pointer}/`)));
    return [...texts.map((pointer) => ({ pointer, message: "a number is missing here" })), ...problems.filter((problem) => !isOfText(problem))];
  }

  /** Where a problem is marked: that bodies overlap where one is placed. */
  #placeOf({ code, pointer }) {
    const places = ["placement/translation_m", "rigid/center_m"].map((member) => `${pointer}/${member}`);
    const placed = code === "initial_overlap" && places.find((place) => this.#inputs.has(place));
    return this.#place(placed || pointer);
  }

  /** The input of a pointer, or of the nearest part around it: in the end the last section. */
  #place(pointer) {
    for (let at = pointer; ; at = at.slice(0, at.lastIndexOf("/"))) {
      if (this.#inputs.has(at)) return { input: this.#inputs.get(at), all: this.#ofVector(at) };
      if (this.#groups.has(at)) return { group: this.#groups.get(at) };
      if (!at) return null;
    }
  }

  /** The input of a pointer, or the three of a vector as a whole. */
  #ofVector(pointer) {
    const own = [0, 1, 2].map((i) => this.#inputs.get(`${pointer}/${i}`)).filter(Boolean);
    return own.length ? own : [this.#inputs.get(pointer)];
  }

  /** What a pointer leads to in the words of the form: "flashball › mesh › outer radius". */
  nameOf(pointer) {
    let value = this.#document;
    const steps = pointer.split("/").slice(1).map((step) => step.replaceAll("~1", "/").replaceAll("~0", "~")).flatMap((step) => {
      value = value?.[step];
      if (/^\d+$/.test(step)) return [value?.name?.trim() || value?.part || value?.role || `number ${Number(step) + 1}`];
      return ["bodies", "parts"].includes(step) ? [] : [words(step).replace(/ \[.*/, "")];
    });
    return steps.join(" › ") || "the scene";
  }

  /** Puts the cursor where a problem is. */
  focus(problem) {
    const place = this.#placeOf(problem);
    const target = place?.input ?? place?.group?.firstElementChild;
    target?.scrollIntoView({ block: "center" });
    target?.focus();
  }
}

/** The member that a pointer leads to: of an entry of a list that of the list. */
const keyOf = (pointer) => pointer.split("/").findLast((step) => !/^\d+$/.test(step)) ?? "";

/** A problem in a sentence or two, in the words and units of the form. */
export function problemWords({ message, limit, remedy, pointer }) {
  const key = keyOf(pointer ?? "");
  const bound = limit && inForm(limit, key);
  const inUnits = (text) => inForm(text, isOfComputer(key) ? key : null);
  return [inUnits(message), bound && `(${bound.startsWith("usually") ? "" : "must be "}${bound})`, remedy && `— ${inUnits(remedy)}`].filter(Boolean).join(" ");
}
