// The four numbers of two runs, and their difference.

import { html, table } from "../dom.js";
import { change, digitsWithin } from "../format.js";
import { bracketed, errorWords, hasError, headline, isMiss } from "../summary/headline.js";
import { stoppedAt } from "../summary/trust.js";

/** The four numbers of both, and B − A; a difference below the sum of the errors says nothing. */
export function numbersTable([a, b]) {
  const [left, right] = [headline(a.summary), headline(b.summary)];
  const rows = left.map((p, i) => {
    const q = right[i];
    // Depths above different thresholds are different numbers.
    const isSame = p.label === q.label;
    const name = `${isSame ? p.label : `${p.label}; ${q.label}`} [${p.unit}]`;
    const isComparable = isSame && p.quantity && q.quantity && [a, b].every(({ summary }) => !summary.withheld && !isMiss(summary));
    return [name, numberCell(a.summary, p), numberCell(b.summary, q), isComparable ? differenceCell(p.quantity, q.quantity) : "–"];
  });
  return html("section", { class: "panel" }, table("The four numbers with their errors", ["number", runTitle(a), runTitle(b), "B − A"], rows));
}

export function runTitle({ label, job, summary }) {
  const stopped = stoppedAt(summary);
  return `${label}: ${job.name}${stopped ? ` (${summary.ending} at ${stopped})` : ""}`;
}

function numberCell(summary, { quantity }) {
  if (!quantity) return "–";
  if (isMiss(summary)) return "nothing touched";
  return summary.withheld ? "withheld" : `${bracketed(quantity)}${hasError(quantity) ? " " : ", error "}${errorWords(quantity, "")}`;
}

function differenceCell(p, q) {
  const difference = q.value - p.value;
  const fraction = p.value === 0 ? "" : ` (${change((100 * difference) / p.value, 100, 2)} %)`;
  const digits = digitsWithin(difference, (p.error?.total ?? 0) + (q.error?.total ?? 0));
  return html("span", {}, `${change(difference, Math.max(Math.abs(p.value), Math.abs(q.value)), digits)}${fraction} `, verdict(p, q, difference));
}

function verdict(p, q, difference) {
  if (!hasError(p) || !hasError(q)) return html("span", { class: "badge" }, "errors unknown");
  const isClear = Math.abs(difference) > p.error.total + q.error.total;
  return html("span", { class: isClear ? "badge good" : "badge warn" }, isClear ? "beyond the errors" : "within the errors");
}
