// The answer to a what-if question: a table of cases that fills as they come, and what each parameter does by itself.

import { html, saveFile, button, table } from "../dom.js";
import { ABOUT_MARKS, bracketed, commaSeparated, exceeds, number, setting, within } from "../format.js";
import { endsWithin, isCut, possibleOf } from "../scene/possible.js";
import { threshold } from "../summary/headline.js";
import { effectsTable } from "./what_if_effects.js";
import { limitList } from "./what_if_limit.js";

/** The four numbers, by their names on the wire; the depth is that above a threshold [Pa]. */
export function numbersAbove(pascal) {
  return [
    ["peak_force_n", "peak force [N]"],
    ["largest_patch_area_mm2", "largest patch [mm²]"],
    ["stress_depth_mm", `depth of stress above ${pascal == null ? "the first threshold of the scene" : threshold(pascal)} [mm]`],
    ["energy_given_j", "energy given [J]"],
  ];
}

/** Lengths in metres are read in millimetres. */
const readable = (unit) => (unit === "m" ? { unit: "mm", factor: 1e3 } : { unit, factor: 1 });

/** Both ends of a number within what is possible: none where its error is not known, no upper one of a lower bound. */
function endsOf(quantity, isLeast, possible) {
  if (quantity?.error == null) return [null, null];
  const [lower, upper] = endsWithin(possible, quantity.value, quantity.error);
  return [lower, isLeast ? null : upper];
}

/** A number with its error; with its ends instead where the error leads beyond what is possible. */
function words(quantity, isLeast, possible) {
  if (!quantity) return "–";
  const { value, error } = quantity;
  if (error == null) return bracketed(value, null, isLeast);
  const shown = bracketed(value, error, isLeast);
  if (!isCut(endsWithin(possible, value, error), error)) return `${shown}\u00a0±\u00a0${number(error, 2)}`;
  const [lower, upper] = endsOf(quantity, isLeast, possible).map((end) => end != null && within(end, error));
  return isLeast ? `${shown}, from ${lower}` : `${shown}, ${lower} to ${upper}`;
}

/** What an answer calls a number, with the threshold that it is about. */
function titleIn({ quantities }, key) {
  return quantities?.[key] && `${quantities[key].title} [${quantities[key].unit}]`;
}

/** Digits of a parameter in a case: an answer may propose values of many. */
const DIGITS = 4;

export class WhatIfAnswer {
  element = html("div");
  #known;
  #numbers;
  #asked;
  #cases = new Map();
  #sensitivities = html("div");
  #limits = html("div");
  #count = 0;
  #found = [];
  #isWhole = false;

  /**
   * `known` describes parameters by name: {label, unit, factor, base}; what is not known is shown as it is. `significant` is the
   * threshold [Pa] that depths are above, if it is known before the answer comes; `asked` the question of the page *Ask* that is answered, if it is one.
   */
  constructor(known = new Map(), significant = null, asked = null) {
    [this.#known, this.#asked] = [known, asked];
    this.#numbers = numbersAbove(significant);
    this.#show();
  }

  /** Takes in an event of the job. */
  take({ event, data }) {
    if (event === "case") {
      this.#takeUnits(data.units);
      this.#cases.set(data.index, data);
      this.#count = data.of;
      this.#show();
    }
  }

  /** Takes in the units of parameters, by name, where nothing better is known of them. */
  #takeUnits(units) {
    for (const [name, unit] of Object.entries(units)) if (!this.#known.has(name)) this.#known.set(name, { label: name, ...readable(unit) });
  }

  /** Takes in the whole answer. */
  takeAll(answer) {
    this.#takeUnits(Object.fromEntries(answer.parameters.map(({ name, unit }) => [name, unit])));
    answer.cases.forEach((one) => this.#cases.set(one.index, one));
    this.#count = answer.requested_cases;
    this.#isWhole = true;
    this.#numbers = this.#numbers.map(([key, title]) => [key, titleIn(answer, key) ?? title]);
    if (answer.sensitivities.length) {
      const base = answer.cases[0]?.numbers;
      this.#sensitivities.replaceChildren(effectsTable(answer.sensitivities, this.#numbers, base, (name) => this.#describe(name)));
    }
    const titleOf = (key) => titleIn(answer, key) ?? this.#numbers.find(([one]) => one === key)?.[1] ?? key;
    this.#found = answer.limits;
    this.#limits.replaceChildren(limitList(this.#found, titleOf, (name) => this.#describe(name)));
    this.errorBars = answer.error_bars;
    this.#show();
  }

  /** What was set in the cases by hand, in their order: values by parameter, without those of the base. */
  get asked() {
    const cases = [...this.#cases.values()].sort((a, b) => a.index - b.index);
    const base = cases[0]?.parameters ?? {};
    const changed = ({ parameters }) => Object.entries(parameters).filter(([name, value]) => value !== base[name]);
    return cases.filter(({ origin }) => origin.kind === "case").map((one) => ({ set: Object.fromEntries(changed(one)) }));
  }

  /** The limits that were asked for. */
  get askedLimits() {
    return this.#found.map(({ parameter, measure, at_most }) => ({ parameter, measure, at_most }));
  }

  /** The numbers that are shown: [name on the wire, title]. */
  get shown() {
    return this.#numbers;
  }

  #describe(name) {
    return this.#known.get(name) ?? { label: name, unit: "", factor: 1 };
  }

  #show() {
    const cases = [...this.#cases.values()].sort((a, b) => a.index - b.index);
    if (!cases.length) return this.element.replaceChildren(html("p", { class: "quiet" }, "No case yet."));
    const base = cases[0]?.parameters ?? {};
    const names = Object.keys(base);
    const heads = names.map((name) => {
      const { label, unit } = this.#describe(name);
      return `${label.split(",")[0]}${unit && unit !== "-" ? ` [${unit}]` : ""}`;
    });
    const rows = cases.map((one) => {
      const values = names.map((name) => {
        const text = setting(Number((one.parameters[name] * this.#describe(name).factor).toPrecision(DIGITS)));
        return one.parameters[name] === base[name] ? html("span", { class: "quiet" }, text) : html("b", {}, text);
      });
      const ofBase = this.#asked ? `${setting(base.speed)} m/s` : "as it was";
      return [one.index === 0 ? ofBase : one.name, ...values, ...this.#numbers.map(([key], i) => this.#cell(one, key, i))];
    });
    const caption = cases.length < this.#count ? `${cases.length} of ${this.#count} cases` : `${cases.length === 1 ? "1 case" : `${cases.length} cases`}; what differs from the base is bold`;
    const shown = table(caption, ["case", ...heads, ...this.#numbers.map(([, title]) => title)], rows);
    shown.classList.add("cases");
    this.element.replaceChildren(
      this.#limits,
      shown,
      ...this.#notes(cases).map((note) => html("p", { class: "quiet" }, note)),
      button("CSV", () => this.#saveCsv(cases, names), { "aria-label": "Cases as CSV" }),
      this.#sensitivities,
    );
  }

  /** What a number of a case can be. */
  #possible({ parameters }, key) {
    return possibleOf(key, this.#asked)(parameters.speed);
  }

  /** Whether the error of a number leads beyond what is possible. */
  #isCut(one, key) {
    const { value, error } = one.numbers?.[key] ?? {};
    return error != null && isCut(endsWithin(this.#possible(one, key), value, error), error);
  }

  /** A number of a case on one line; why there is none in place of the first. */
  #cell(one, key, column) {
    const { ending, reason, lower_bounds: bounds, numbers } = one;
    if (ending !== "finished") return column === 0 ? html("span", { class: "badge warn", title: reason }, ending.replaceAll("_", " ")) : "";
    return words(numbers[key], bounds?.includes(key), this.#possible(one, key));
  }

  /** What the cells do not say, each thing once. */
  #notes(cases) {
    const quantities = cases.flatMap(({ numbers }) => this.#numbers.map(([key]) => numbers?.[key]).filter(Boolean));
    const ends = new Set(cases.flatMap(({ reaches }) => reaches ?? []));
    const isBounded = cases.some(({ lower_bounds: bounds }) => this.#numbers.some(([key]) => bounds?.includes(key)));
    const reasons = new Set(cases.filter(({ ending }) => ending !== "finished").map(({ ending, reason }) => `${ending.replaceAll("_", " ")}: ${reason ?? "no reason is known"}`));
    return [
      (isBounded || quantities.some(({ value, error }) => error == null || !exceeds(value, error))) && ABOUT_MARKS,
      quantities.some(({ error }) => error == null) && `Without ±: the error is not known${this.#isWhole ? "" : " yet"}.`,
      cases.some((one) => this.#numbers.some(([key]) => this.#isCut(one, key))) && "12, 0 to 30: both ends of the number with its error, within what is possible.",
      isBounded && `≥ here: ${ends.size ? `the stress reaches ${[...ends].join(" and ")}, or ` : ""}the run ended while it was growing.`,
      ...reasons,
      this.errorBars && `Errors: ${this.errorBars}.`,
    ].filter(Boolean);
  }

  #saveCsv(cases, names) {
    const head = ["case", "ending", ...names, ...this.#numbers.flatMap(([key]) => [key, `${key}_error`, `${key}_from`, `${key}_to`]), "lower_bounds"];
    const numbers = (one) => this.#numbers.flatMap(([key]) => {
      const quantity = one.numbers[key];
      return [quantity?.value, quantity?.error, ...endsOf(quantity, one.lower_bounds?.includes(key), this.#possible(one, key))];
    });
    const rows = cases.map((one) => [one.name, one.ending, ...names.map((name) => one.parameters[name]), ...numbers(one), (one.lower_bounds ?? []).join(" ")]);
    saveFile("what-if.csv", commaSeparated([head, ...rows]), "text/csv");
  }
}
