// A form of a scene document: one input for every number and word in it, found again by its JSON pointer.

import { html } from "../dom.js";

/** Units at the ends of names, longest first. */
const UNITS = [
  ["_kg_per_m3", "kg/m³"], ["_m_per_s2", "m/s²"], ["_m_per_s", "m/s"], ["_rad_per_s", "rad/s"], ["_n_per_m", "N/m"],
  ["_deg", "°"], ["_pa", "Pa"], ["_kg", "kg"], ["_m", "m"], ["_s", "s"], ["_n", "N"], ["_j", "J"],
];

/** Parts that are open at first. */
const OPEN = [/^$/, /^\/bodies$/, /^\/bodies\/\d+$/];

/** A name of the document as words: `outer_radius_m` → outer radius [m]. */
export function words(key) {
  const unit = UNITS.find(([end]) => key.endsWith(end) && key.length > end.length);
  const name = (unit ? key.slice(0, -unit[0].length) : key).replaceAll("_", " ");
  return unit ? `${name} [${unit[1]}]` : name;
}

const escaped = (key) => String(key).replaceAll("~", "~0").replaceAll("/", "~1");
const isVector = (value) => Array.isArray(value) && value.length === 3 && value.every((c) => typeof c === "number");
const isLeaf = (value) => value === null || typeof value !== "object";

export class SceneForm {
  element = html("div", { class: "scene-form" });
  #inputs = new Map();
  #groups = new Map();
  #onChange;
  #opened = new Map();

  /** `onChange()` after the document that was given to `show` has been changed by an input. */
  constructor(onChange) {
    this.#onChange = onChange;
  }

  show(document) {
    this.#inputs.clear();
    this.#groups.clear();
    this.element.replaceChildren(...this.#contents(document, ""));
  }

  /** Inputs of the leaves of an object, then its parts. */
  #contents(value, pointer) {
    const entries = Object.entries(value);
    const simple = entries.filter(([, inner]) => isLeaf(inner) || isVector(inner));
    const grid = html("div", { class: "form-grid" }, simple.map(([key, inner]) => this.#field(value, key, inner, `${pointer}/${escaped(key)}`)));
    const parts = entries.filter(([, inner]) => !isLeaf(inner) && !isVector(inner)).map(([key, inner]) => this.#part(key, inner, `${pointer}/${escaped(key)}`));
    return [...(simple.length ? [grid] : []), ...parts];
  }

  #part(key, value, pointer) {
    const title = value.name ?? value.part ?? (/^\d+$/.test(key) ? `number ${Number(key) + 1}` : words(key));
    const isOpen = this.#opened.get(pointer) ?? OPEN.some((pattern) => pattern.test(pointer));
    const part = html("details", { open: isOpen, ontoggle: () => this.#opened.set(pointer, part.open) }, html("summary", {}, title), this.#contents(value, pointer));
    this.#groups.set(pointer, part);
    return part;
  }

  #field(owner, key, value, pointer) {
    const label = html("span", {}, words(key));
    if (isVector(value)) {
      const inputs = value.map((component, i) => this.#input(value, i, component, `${pointer}/${i}`, `${words(key)}, ${"xyz"[i]}`));
      const group = html("div", { class: "field wide", role: "group", "aria-label": words(key) }, label, html("span", { class: "vector" }, inputs));
      this.#inputs.set(pointer, inputs[0]);
      return group;
    }
    const input = this.#input(owner, key, value, pointer);
    const isWide = typeof value === "string" && value.length > 24;
    return html("label", { class: isWide ? "field wide" : "field" }, label, input);
  }

  #input(owner, key, value, pointer, name) {
    const take = () => {
      owner[key] = typeof value === "number" ? numberOf(input.value) : typeof value === "boolean" ? input.checked : input.value;
      this.#onChange();
    };
    const kind = { number: { inputmode: "decimal", type: "text", value: String(value) }, boolean: { type: "checkbox", checked: value === true } };
    const attributes = kind[typeof value] ?? { type: "text", value: value ?? "" };
    const input = html("input", { ...attributes, "aria-label": name, "data-pointer": pointer, oninput: take });
    this.#inputs.set(pointer, input);
    return input;
  }

  /** Shows what is wrong, each beside its input, or beside the part that holds its place. */
  showProblems(problems) {
    this.element.querySelectorAll(".field-error").forEach((error) => error.remove());
    this.element.querySelectorAll("[aria-invalid]").forEach((input) => input.removeAttribute("aria-invalid"));
    for (const problem of problems) {
      const place = this.#place(problem.pointer);
      const message = html("span", { class: "field-error" }, problemWords(problem));
      if (place?.input) {
        place.input.setAttribute("aria-invalid", "true");
        (place.input.closest(".field") ?? place.input).append(message);
      } else place?.group?.firstElementChild.after(message);
      for (let part = (place?.input ?? place?.group)?.closest("details"); part; part = part.parentElement.closest("details")) part.open = true;
    }
  }

  /** The input of a pointer, or of the nearest part around it. */
  #place(pointer) {
    for (let at = pointer; at; at = at.slice(0, at.lastIndexOf("/"))) {
      if (this.#inputs.has(at)) return { input: this.#inputs.get(at) };
      if (this.#groups.has(at)) return { group: this.#groups.get(at) };
    }
    return null;
  }

  /** Puts the cursor where a problem is. */
  focus(pointer) {
    const place = this.#place(pointer);
    const target = place?.input ?? place?.group?.firstElementChild;
    target?.scrollIntoView({ block: "center" });
    target?.focus();
  }
}

/** What is no number stays the word that it is, for the service to refuse with its place. */
function numberOf(text) {
  const plain = text.trim().replace(",", ".");
  return plain !== "" && Number.isFinite(Number(plain)) ? Number(plain) : text;
}

/** A problem in a sentence or two. */
export function problemWords({ message, limit, remedy }) {
  return [message, limit && `(limit: ${limit})`, remedy && `— ${remedy}`].filter(Boolean).join(" ");
}
