// What polynomials through the computed cases propose for the sliders' values, before the model answers.

import { html, table } from "../dom.js";
import { number } from "../format.js";

/** What a surrogate proposes at values by name: null outside of what its cases cover. */
export function propose({ ranges, terms }, values) {
  const places = {};
  for (const [name, [low, high]] of Object.entries(ranges)) {
    const value = values.get(name);
    if (value == null || value < low || value > high) return null;
    places[name] = (2 * value - low - high) / (high - low);
  }
  return terms.reduce((sum, { parameters, coefficient }) => sum + parameters.reduce((product, name) => product * places[name], coefficient), 0);
}

export class WhatIfProposal {
  element = html("div", { class: "what-if-proposal", "aria-live": "polite" });
  #surrogates = [];
  #titles = new Map();

  /** Takes over what an answer has: its surrogates of the numbers that `shown` names, with their titles. */
  take(surrogates, shown) {
    this.#titles = new Map(shown);
    this.#surrogates = shown.map(([key]) => surrogates.find(({ quantity }) => quantity === key)).filter(Boolean);
  }

  /** Shows what is proposed at values by name. */
  show(values) {
    if (!this.#surrogates.length) return this.element.replaceChildren();
    const rows = this.#surrogates.map((surrogate) => {
      const proposed = propose(surrogate, values);
      const words = proposed == null ? "beyond what was computed" : `${number(proposed)}\u00a0±\u00a0${number(surrogate.hold_out_error, 2)}`;
      return [this.#titles.get(surrogate.quantity), words];
    });
    const { cases } = this.#surrogates[0];
    this.element.replaceChildren(
      table(`Proposed, not computed: a polynomial through ${cases} cases, ± what it is off on a case that it has not seen`, ["number", "proposed"], rows),
    );
  }
}
