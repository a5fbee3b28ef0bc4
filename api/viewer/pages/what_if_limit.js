// Up to which speed, fat, … a number stays below a limit: what is asked, and the answer in words.

import { button, html, select } from "../dom.js";
import { number, setting, within } from "../format.js";

/** The fields of one limit, which is asked for by a button. */
export class WhatIfLimit {
  element;
  #parameters;
  #numbers;
  #parameter;
  #number;
  #most = html("input", { type: "number", min: 0, step: "any", "aria-label": "Limit", required: true });

  /** `parameters` of the sliders; `numbers` [[name on the wire, title with unit]]; `onAsk(limit, parameter)`. */
  constructor(parameters, numbers, onAsk) {
    this.#parameters = parameters;
    this.#numbers = numbers;
    [this.#parameter, this.#number] = [parameters[0]?.name, numbers[0][0]];
    const choices = parameters.map(({ name, label }) => [name, label.split(",")[0]]);
    this.element = html("div", { class: "tools what-if-limit" },
      select("Up to which", choices, this.#parameter, (name) => (this.#parameter = name)),
      select("stays the", numbers, this.#number, (key) => (this.#number = key)),
      html("label", { class: "field" }, html("span", {}, "at or below"), this.#most),
      button("Find the limit", () => this.#most.reportValidity() && onAsk(this.#limit, this.#parameters.find(({ name }) => name === this.#parameter))));
  }

  get #limit() {
    return { parameter: this.#parameter, measure: { quantity: this.#number }, at_most: Number(this.#most.value) };
  }
}

/** The answers to limits as a list; `titleOf(key)` of a number with its unit, `describe(name)` of a parameter {label, unit, factor}. */
export function limitList(limits, titleOf, describe) {
  if (!limits?.length) return "";
  return html("section", { class: "limits" }, html("h2", {}, "Limits"), html("ul", {}, limits.map((limit) => html("li", {}, limitWords(limit, titleOf, describe)))));
}

/** A number with its unit from a title such as "peak force [N]": [name, unit]. */
const splitTitle = (title) => title.match(/^(.*) \[(.*)\]$/)?.slice(1) ?? [title, ""];

/** Where a limit is met, in words; null for nowhere in the range, or without an answer. */
function placeOf(verdict, words) {
  if (verdict?.verdict === "kept_up_to") return `up to ${words(verdict.kept_at)}`;
  return verdict?.verdict === "kept_from" ? `from ${words(verdict.kept_at)} on` : null;
}

/** A limit in words: its place to the digits that the error of the number leaves, in brackets where that is not resolved, or not known. */
function limitWords(limit, titleOf, describe) {
  const { parameter, measure, verdict, values, reason, at, kept_at: keptAt, resolved, relative_error: error } = limit;
  const { label, unit, factor } = describe(parameter);
  const [name, unitOf] = measure.quantity ? splitTitle(titleOf(measure.quantity)) : [`stress below ${number(1e3 * measure.von_mises_pa_below_depth_m)} mm`, "kPa"];
  const scale = measure.quantity ? 1 : 1e-3;
  const words = (value, shown = number(value * factor, 3)) => `${shown} ${unit === "-" ? "" : unit}`.trim();
  const what = `${label.split(",")[0]}: `;
  if (verdict === "no_number") return `${what}no answer, since at ${words(at)} there is no number (${reason}).`;
  if (verdict === "open") {
    return `${what}no answer, since at ${words(at)} the ${name} is only known to be at least ${number(limit.at_least * scale, 3)} ${unitOf}: that does not show whether it stays at or below ${setting(limit.at_most * scale)} ${unitOf}.`;
  }
  const of = `${what}the ${name} ${verdict === "broken_at_both_ends" ? "is above" : "stays at or below"} ${setting(limit.at_most * scale)} ${unitOf}`;
  const remark = uncertainty(limit, words);
  if (values) return `${of} at both ends of its range (${values.map((value) => number(value * scale, 3)).join(" and ")} ${unitOf})${remark}`;
  const widths = [limit.if_larger, limit.if_smaller].map((one) => Math.abs((one?.kept_at ?? keptAt) - keptAt));
  const width = Math.max(...widths) * factor;
  const digits = width > 0 ? within(keptAt * factor, width) : number(keptAt * factor, 2);
  const place = resolved !== false && error != null ? digits : `(${digits})`;
  return `${of} ${placeOf(limit, () => words(keptAt, place))}${remark}`;
}

/** What the numerical error of the number makes of the limit. */
function uncertainty({ resolved, relative_error: error, if_larger: larger, if_smaller: smaller }, words) {
  if (error == null) return "; its numerical error is not known.";
  const percent = `± ${number(100 * error, 2)} %`;
  if (resolved === false) return `; the number is not resolved (${percent}), so that the limit may be elsewhere.`;
  if (larger?.verdict === "broken_at_both_ends" && smaller?.verdict === "kept_at_both_ends") return `; not resolved by these runs: within the numerical error of the number, ${percent}, the limit may be met in the whole range, or nowhere in it.`;
  const atBoth = { kept_at_both_ends: "at both ends of the range", broken_at_both_ends: "at neither end of the range" };
  const ends = [larger, smaller].map((verdict) => placeOf(verdict, (value) => words(value)) ?? atBoth[verdict?.verdict] ?? "not known");
  return `; with the numerical error of the number, ${percent}: ${[...new Set(ends)].join(", or ")}.`;
}
