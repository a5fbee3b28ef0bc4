// Whether the numbers can be trusted: how the run ended, its checks, its warnings.

import { html, term } from "../dom.js";
import { number, timeUnit, withUnit } from "../format.js";
import { plainly } from "./plain_terms.js";

/** Where a run ended that did not reach its end, in words; null for one that did, or that goes on. */
export function stoppedAt({ ending, time_s, end_time_s }) {
  if (ending !== "failed" && ending !== "cancelled") return null;
  const { factor, name } = timeUnit(end_time_s);
  return withUnit(time_s * factor, name);
}

/** Why a run gives no results, or not all, in words; null when it went to its end and passed. */
export function reason(summary) {
  const { ending, failure, withheld } = summary;
  if (withheld) return `withheld: ${withheld.reason}`;
  if (ending === "failed") return `the run failed at ${stoppedAt(summary)}: ${failure?.message ?? "no diagnosis"}`;
  if (ending === "cancelled") return `the run was cancelled at ${stoppedAt(summary)}`;
  return null;
}

/** A line above pictures and curves of runs [{label, summary}] that are no results; null where all are. */
export function withheldLine(runs) {
  const withheld = runs.filter(({ summary }) => summary?.withheld);
  if (!withheld.length) return null;
  const items = withheld.map(({ label, summary: { withheld: { reason: why } } }) => html("span", {}, label && ` ${label}:`, " ", term(why.split(/[,;:] /)[0], why), "."));
  return html("p", { class: "warning-line bad withheld" }, html("span", {}, html("b", {}, "Withheld, no result."), items));
}

/** Checks, warnings and sources of error, collapsed. */
export function trustPanel(summary, concerns) {
  const stopped = stoppedAt(summary);
  return html(
    "details",
    { class: "panel trust" },
    html("summary", {}, html("h2", {}, "Can these numbers be trusted?")),
    concerns.length ? html("ul", { class: "warnings" }, concerns.map(({ kind, words }) => html("li", { class: kind }, plainly(words)))) : html("p", { class: "quiet" }, "No warnings."),
    html("p", {}, stopped ? `The checks looked at what was computed up to ${stopped}:` : "Checks of the computation:"),
    html("ul", { class: "gates" }, summary.gates.map((gate) => gateItem(gate, stopped))),
    html("p", { class: "quiet" }, `Uncertainties: ${summary.error_bars}. They cover the computation, not how well the model represents a person.`),
  );
}

function gateItem({ result, meaning, value, limit }, stopped) {
  const isPassed = result === "passed";
  const words = isPassed ? (stopped ? "so far within its limit" : "✓ passed") : "✗ failed";
  return html("li", { class: isPassed ? (stopped ? "gate" : "gate good") : "gate bad" }, html("b", {}, `${words} `), `${meaning}: ${number(value, 2)} (limit ${number(limit, 2)})`);
}
