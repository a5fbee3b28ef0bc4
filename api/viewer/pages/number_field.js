// A number of the reader's, or three along x, y and z: inputs with a label, a short explanation, and what is wrong with them.

import { html } from "../dom.js";
import { setting } from "../format.js";

const numberOf = ({ value }) => Number(value.trim().replace(",", ".").replace("−", "-") || NaN);

export class NumberField {
  #inputs;
  #error = html("span", { class: "field-error", hidden: true });
  #isTyped = false;

  /** `axes` for a vector; `about` explains it; `onchange()` after the reader has typed. */
  constructor(label, { value = "", axes = [], about, onchange = () => {} } = {}) {
    const typed = () => {
      this.#isTyped = true;
      this.mark("");
      onchange();
    };
    const input = (name) => html("input", { type: "text", inputmode: "decimal", value, "aria-label": name, oninput: typed });
    this.#inputs = axes.length ? axes.map((axis) => input(label.replace(/ \[|$/, `, ${axis}$&`))) : [input(label)];
    const inputs = axes.length ? html("span", { class: "vector" }, this.#inputs) : this.#inputs;
    const rest = [inputs, about && html("small", { class: "quiet" }, about), this.#error];
    const words = html("span", {}, label);
    this.element = axes.length ? html("div", { class: "field double", role: "group", "aria-label": label }, words, rest) : html("label", { class: "field" }, words, rest);
  }

  /** The numbers, NaN for those that are none. */
  get numbers() {
    return this.#inputs.map(numberOf);
  }

  get number() {
    return this.numbers[0];
  }

  get isEmpty() {
    return this.#inputs.every(({ value }) => !value.trim());
  }

  set disabled(isDisabled) {
    for (const input of this.#inputs) input.disabled = isDisabled;
  }

  /** Puts numbers there. */
  put(...values) {
    this.#inputs.forEach((input, k) => (input.value = setting(values[k])));
  }

  /** Puts numbers there, unless the reader has typed some. */
  suggest(...values) {
    if (!this.#isTyped) this.put(...values);
  }

  /** Says what is wrong; nothing with no words. */
  mark(words) {
    for (const input of this.#inputs) words ? input.setAttribute("aria-invalid", "true") : input.removeAttribute("aria-invalid");
    this.#error.textContent = words;
    this.#error.hidden = !words;
  }
}
