// The four numbers of two runs, and their difference where they can be compared.

import { html, table } from "../dom.js";
import { ABOUT_MARKS, change, timeUnit, withUnit } from "../format.js";
import { contactEnded, headline, isLeast, isMiss, resultsOf } from "../summary/headline.js";
import { hasError, isResolved, numberWithError } from "../summary/quantity.js";
import { stoppedAt } from "../summary/trust.js";

/** Ends of runs and windows of means that differ by less than this fraction are the same [-]. */
const SAME = 1e-6;

/** The four numbers of both, and B − A of those that are resolved in both; a difference below the sum of the errors says nothing. */
export function numbersTable([a, b]) {
  const [left, right] = [headline(a.summary), headline(b.summary)];
  const obstacle = obstacleOfRuns(a, b);
  const rows = left.map((p, i) => {
    const q = right[i];
    const name = `${p.label === q.label ? p.label : `${p.label}; ${q.label}`} [${p.unit}]`;
    const why = obstacle ? "" : obstacleOfNumbers(p, q) ?? (p.isOfTheEnd ? obstacleOfEnds(a, b) : null);
    return [name, numberCell(a.summary, p), numberCell(b.summary, q), why == null ? differenceCell(p, q) : notComparable(why)];
  });
  const remark = obstacle ? `Not comparable: ${obstacle}.` : remarkOn(a, b);
  return html("section", { class: "panel" }, table("The four numbers with their errors", ["number", runTitle(a), runTitle(b), "B − A"], rows), remark && html("p", { class: "quiet" }, remark), html("p", { class: "quiet" }, ABOUT_MARKS));
}

export function runTitle({ label, job, summary }) {
  const stopped = stoppedAt(summary);
  return `${label}: ${job.name}${stopped ? ` (${summary.ending} at ${stopped})` : ""}`;
}

const hasEnded = ({ summary }) => contactEnded(resultsOf(summary));
const isSame = (a, b) => Math.abs(a - b) <= SAME * Math.max(Math.abs(a), Math.abs(b));
const endOf = ({ summary: { time_s: end } }) => withUnit(end * timeUnit(end).factor, timeUnit(end).name);

/** Why no number of two runs can be compared, in words; null where that depends on the number. */
function obstacleOfRuns(a, b) {
  const labels = (runs) => runs.map(({ label }) => label).join(" and ");
  const which = (isSo) => [a, b].filter(isSo);
  const withheld = which(({ summary }) => summary.withheld);
  if (withheld.length) return `the numbers of ${labels(withheld)} are withheld`;
  const missed = which(({ summary }) => isMiss(summary));
  if (missed.length) return `nothing touched in ${labels(missed)}`;
  const stopped = which(({ summary }) => stoppedAt(summary));
  if (stopped.length) return `${labels(stopped)} ended early`;
  const touching = which((run) => !hasEnded(run));
  if (touching.length === 1) return `contact has not ended in ${labels(touching)}`;
  return touching.length ? obstacleOfEnds(a, b) : null;
}

/** Why numbers that depend on the end of the run cannot be compared, in words; null where they can. */
function obstacleOfEnds(a, b) {
  return isSame(a.summary.time_s, b.summary.time_s) ? null : `A ends at ${endOf(a)}, B at ${endOf(b)}`;
}

/** What comparable numbers of two runs are not; null for those of a contact that has ended. */
function remarkOn(a, b) {
  return hasEnded(a) ? null : `Contact has not ended in either run: these are the numbers up to ${endOf(a)}, not those of the whole impact.`;
}

/** Why one of the four numbers of two runs cannot be compared, in words; null where it can. */
function obstacleOfNumbers(p, q) {
  if (!p.quantity || !q.quantity) return "not in both";
  if (p.label !== q.label) return "above different thresholds";
  const unresolved = [p, q].map(({ quantity }) => hasError(quantity) && !isResolved(quantity));
  if (unresolved.includes(true)) return `not resolved in ${["A", "B"].filter((_, i) => unresolved[i]).join(" and ")}`;
  if (isCut(p) && isCut(q)) return "both are lower bounds";
  if (p.average == null || p.average === q.average || isSame(p.average, q.average)) return null;
  return `averaged over ${averageWords(p)} and ${averageWords(q)}; one window for both makes them so`;
}

function averageWords({ average }) {
  if (typeof average !== "number") return String(average);
  const { factor, name } = timeUnit(average);
  return withUnit(average * factor, name);
}

/** Whether a number is a lower bound whatever the time, not the value up to the end of the run. */
const isCut = ({ quantity, isGrowing }) => isLeast(quantity) && !isGrowing;

function numberCell(summary, { quantity }) {
  if (!quantity) return "–";
  if (isMiss(summary)) return "nothing touched";
  if (summary.withheld) return "withheld";
  return numberWithError(quantity);
}

function notComparable(why) {
  return html("span", {}, html("span", { class: "badge" }, "not comparable"), ` ${why}`);
}

/** B − A with what the errors say of it; where one is a lower bound, the difference is a bound. */
function differenceCell(p, q) {
  const [before, after] = [p.quantity, q.quantity];
  const difference = after.value - before.value;
  const errors = (before.error?.total ?? 0) + (after.error?.total ?? 0);
  const words = change(difference, Math.max(Math.abs(before.value), Math.abs(after.value)), errors);
  const isBound = isCut(p) || isCut(q);
  const fraction = before.value === 0 || isBound ? "" : ` (${change((100 * difference) / before.value, 100, (100 * errors) / Math.abs(before.value))} %)`;
  const bound = isBound ? `at ${isCut(q) ? "least" : "most"} ` : "";
  return html("span", {}, `${bound}${words}${fraction} `, verdict(p, q, difference));
}

function verdict(p, q, difference) {
  if (!hasError(p.quantity) || !hasError(q.quantity)) return html("span", { class: "badge" }, "errors unknown");
  const errors = p.quantity.error.total + q.quantity.error.total;
  // A bound says something only on its own side.
  if (isCut(p) || isCut(q)) {
    const isClear = (isCut(q) ? difference : -difference) > errors;
    return html("span", { class: isClear ? "badge good" : "badge" }, isClear ? "beyond the errors" : "open: a lower bound");
  }
  const isClear = Math.abs(difference) > errors;
  return html("span", { class: isClear ? "badge good" : "badge warn" }, isClear ? "beyond the errors" : "within the errors");
}
