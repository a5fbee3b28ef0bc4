// What polynomials through the computed cases propose for the sliders' values, before the model answers.

import { html, table } from "../dom.js";
import { bracketed, number } from "../format.js";

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
  #base = {};

  /** Takes over what an answer has: its surrogates of the numbers that `shown` names with their titles, and the numbers of its base. */
  take({ surrogates, cases }, shown) {
    this.#titles = new Map(shown);
    this.#base = cases[0]?.numbers ?? {};
    this.#surrogates = shown.map(([key]) => surrogates.find(({ quantity }) => quantity === key)).filter(Boolean);
  }

  /** Shows what is proposed at values by name. */
  show(values) {
    if (!this.#surrogates.length) return this.element.replaceChildren();
    const rows = this.#surrogates.map((surrogate) => {
      const proposed = propose(surrogate, values);
      const words = proposed == null ? "beyond what was computed" : this.#words(proposed, surrogate);
      return [this.#titles.get(surrogate.quantity), words];
    });
    const { cases } = this.#surrogates[0];
    this.element.replaceChildren(
      table(`Proposed, not computed: a polynomial through ${cases} cases, with the numerical error of the base in proportion, and the error of the polynomial at a case that is not in the fit`, ["number", "proposed"], rows),
    );
  }

  /** A proposed number with both of its errors; in brackets when one of them is as large. */
  #words(proposed, { quantity, hold_out_error: holdOut }) {
    const base = this.#base[quantity];
    // The cases have the relative error of the base, too.
    const numerical = base?.error != null && base.value !== 0 ? Math.abs(proposed / base.value) * base.error : null;
    const shown = bracketed(proposed, Math.max(numerical ?? 0, holdOut));
    const first = numerical == null ? "numerical error unknown" : `±\u00a0${number(numerical, 2)} numerical`;
    return `${shown} ${first}, ±\u00a0${number(holdOut, 2)} proposal`;
  }
}
