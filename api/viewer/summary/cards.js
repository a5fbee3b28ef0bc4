// The four numbers as cards: each with its uncertainty as words and as a bar.

import { html, svg, term } from "../dom.js";
import { number, withUnit } from "../format.js";
import { headline, isMiss } from "./headline.js";
import { ABOUT_STRESS } from "./layers.js";
import { bracketed, errorWords, hasError, sureness } from "./quantity.js";
import { stoppedAt } from "./trust.js";

/** The four cards. */
export function headlineCards(summary) {
  if (isMiss(summary)) return html("section", { class: "cards", "aria-label": "Nothing touched" }, missCard(summary));
  const remark = remarkOn(summary);
  return html("section", { class: "cards", "aria-label": "The four numbers" }, remark && html("p", { class: "cards-remark" }, remark), headline(summary).map((item) => card(item, summary)));
}

/** What is true of all four; null where they are results. */
function remarkOn(summary) {
  if (summary.withheld) return "The run failed a check of the computation: its numbers are withheld, they are not results.";
  const stopped = stoppedAt(summary);
  return stopped && `Only to ${stopped}, where the run ended:`;
}

function missCard({ plain_words: words = [] }) {
  return html("article", { class: "card" }, html("h2", {}, "Nothing touched"), html("p", { class: "notes" }, words[0] ?? "There was no impact to evaluate."));
}

function card({ label, unit, quantity, note }, summary) {
  const empty = (big, words) => html("article", { class: "card" }, title(label), html("p", { class: "big quiet" }, big), words && html("p", { class: "notes" }, words));
  if (!quantity) return empty("–", stoppedAt(summary) ? "The run ended before it was known." : "not in this scene");
  if (summary.withheld) return empty("withheld");
  return html(
    "article",
    { class: sureness(quantity) === "sure" ? "card" : "card doubtful" },
    title(label),
    html("p", { class: "big" }, html("span", {}, html("b", {}, bracketed(quantity)), ` ${unit} `), html("span", { class: "error" }, errorOf(quantity, unit))),
    errorBar(quantity),
    note && html("p", { class: "notes" }, note),
  );
}

/** A label, in which stress is explained. */
function title(label) {
  const [before, after] = label.split("stress");
  return html("h2", {}, after == null ? label : [before, term("stress", ABOUT_STRESS), after]);
}

function errorOf(quantity, unit) {
  if (sureness(quantity) !== "unresolved") return hasError(quantity) ? errorWords(quantity, unit) : "uncertainty not estimated";
  return `${errorWords(quantity, unit)}, not resolved: up to ${withUnit(quantity.value + quantity.error.total, unit, 2)}`;
}

/** The number as a dot with its error as a whisker, on an axis from 0. */
function errorBar({ value, error }) {
  if (typeof error !== "object" || !(value + error.total > 0)) return null;
  const scale = 200 / (value + error.total);
  const [left, right, at] = [Math.max(0, value - error.total) * scale, (value + error.total) * scale, value * scale];
  const isOpen = error.total > value;
  return svg(
    "svg",
    { class: "error-bar", viewBox: "-6 -9 212 18", role: "img", "aria-label": `${number(value)} plus or minus ${number(error.total, 2)}` },
    svg("path", { d: "M0 0H200", class: "axis" }),
    svg("path", { d: `M${left} 0H${right}M${right} -5V5${isOpen ? "" : `M${left} -5V5`}`, class: isOpen ? "whisker open" : "whisker" }),
    svg("circle", { cx: at, cy: 0, r: 4.5 }),
  );
}
