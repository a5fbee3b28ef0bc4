// Whether the numbers can be trusted: how the run ended, its gates, its warnings.

import { button, html } from "../dom.js";
import { number, timeUnit, withUnit } from "../format.js";

/** Where a run ended that did not reach its end, in words; null for one that did, or that goes on. */
export function stoppedAt({ ending, time_s, end_time_s }) {
  if (ending !== "failed" && ending !== "cancelled") return null;
  const { factor, name } = timeUnit(end_time_s);
  return withUnit(time_s * factor, name);
}

/** Why a run gives no results, or not all, in words; null when it went to its end and passed. */
function reason(summary) {
  const { ending, failure, withheld } = summary;
  if (withheld) return `withheld: ${withheld.reason}`;
  if (ending === "failed") return `the run failed at ${stoppedAt(summary)}: ${failure?.message ?? "no diagnosis"}`;
  if (ending === "cancelled") return `the run was cancelled at ${stoppedAt(summary)}`;
  return null;
}

/** The verdict in one line, beside the numbers; `onclick` leads to the whole. */
export function trustLine(summary, onclick) {
  const { warnings } = summary;
  const words = warnings.length
    ? html("span", {}, html("span", { class: "badge warn" }, `${warnings.length} ${warnings.length > 1 ? "warnings" : "warning"}`), ` ${warnings[0]}`)
    : html("span", { class: "quiet" }, "no warnings");
  return html("div", { class: "trust-line" }, verdict(summary), words, button("Can these numbers be trusted?", onclick));
}

/** Gates speak of what was computed: of a run that broke off they are no good news. */
function verdict(summary) {
  const why = reason(summary);
  if (why) return html("span", { class: "verdict-words" }, html("span", { class: "badge bad" }, summary.withheld ? "✗ no results" : "✗ not finished"), ` ${why}`);
  const failed = summary.gates.filter((gate) => gate.result !== "passed").length;
  const count = summary.gates.length;
  if (failed) return html("span", { class: "badge bad" }, `✗ ${failed} of ${count} gates failed`);
  return html("span", { class: "badge good" }, `✓ all ${count} gates passed`);
}

/** Gates, warnings and where the errors come from. */
export function trustPanel(summary) {
  const why = reason(summary);
  const stopped = stoppedAt(summary);
  return html(
    "section",
    { class: "panel trust" },
    html("h2", {}, "Can these numbers be trusted?"),
    why && html("p", { class: "alert" }, `No: ${why}`),
    stopped && html("p", { class: "quiet" }, `The gates looked at what was computed up to ${stopped}:`),
    html("ul", { class: "gates" }, summary.gates.map((gate) => gateItem(gate, stopped))),
    summary.warnings.length ? html("ul", { class: "warnings" }, summary.warnings.map((w) => html("li", {}, w))) : html("p", { class: "quiet" }, "No warnings."),
    html("p", { class: "quiet" }, `Error bars: ${summary.error_bars}.`),
    html("p", { class: "quiet" }, summary.notice),
  );
}

function gateItem({ result, meaning, value, limit }, stopped) {
  const isPassed = result === "passed";
  const words = isPassed ? (stopped ? "so far within its limit" : "✓ passed") : "✗ failed";
  return html("li", { class: isPassed ? (stopped ? "gate" : "gate good") : "gate bad" }, html("b", {}, `${words} `), `${meaning}: ${number(value, 2)} (limit ${number(limit, 2)})`);
}
