// The four numbers as cards: each with its uncertainty as words and as a bar.

import { html, svg, term } from "../dom.js";
import { ABOUT_MARKS, number, withUnit, within } from "../format.js";
import { headline, isMiss } from "./headline.js";
import { ABOUT_DEPTH, ABOUT_STRESS } from "./layers.js";
import { digits, errorWords, hasError, isResolved } from "./quantity.js";
import { stoppedAt } from "./trust.js";

/** Words in the cards that are explained. */
const TERMS = [["stress", ABOUT_STRESS], ["below the nearest surface", ABOUT_DEPTH]];

/** The four cards; no depth is more than `deepest` [mm]. */
export function headlineCards(summary, deepest = Infinity) {
  if (isMiss(summary)) return html("section", { class: "cards", "aria-label": "Nothing touched" }, missCard(summary));
  const remark = remarkOn(summary);
  return html("section", { class: "cards", "aria-label": "The four numbers" }, remark && html("p", { class: "cards-remark" }, remark), headline(summary).map((item) => card(item, summary, item.isDepth ? deepest : Infinity)));
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

function card({ label, unit, quantity, isLeast, note }, summary, most) {
  const empty = (big, words) => html("article", { class: "card" }, html("h2", {}, explained(label)), html("p", { class: "big quiet" }, big), words && html("p", { class: "notes" }, words));
  if (!quantity) return empty("–", stoppedAt(summary) ? "The run ended before it was known." : "not in this scene");
  if (summary.withheld) return empty("withheld");
  return html(
    "article",
    { class: isResolved(quantity) ? "card" : "card doubtful" },
    html("h2", {}, explained(label)),
    html("p", { class: "big" }, html("span", {}, html("b", { title: (isLeast || !isResolved(quantity)) && ABOUT_MARKS }, digits(quantity, isLeast)), ` ${unit} `), html("span", { class: "error" }, errorOf(quantity, unit, most))),
    errorBar(quantity, most),
    note && html("p", { class: "notes" }, explained(note)),
  );
}

/** Words, in which the first that has an explanation gets it. */
function explained(words) {
  const [name, about] = TERMS.find(([one]) => words.includes(one)) ?? [];
  if (!name) return words;
  const [before, after] = words.split(name);
  return [before, term(name, about), after];
}

/** The upper end of a number with its error: no more than is possible. */
const endOf = ({ value, error }, most) => Math.min(value + error.total, Math.max(most, value));

function errorOf(quantity, unit, most) {
  if (!hasError(quantity)) return "uncertainty not estimated";
  const end = endOf(quantity, most);
  const isCut = end < quantity.value + quantity.error.total;
  const upTo = `up to ${withUnit(end, unit, 2)}${isCut ? ", where the tissue ends" : ""}`;
  if (!isResolved(quantity)) return `${errorWords(quantity, unit)}, not resolved: ${upTo}`;
  return isCut ? `${errorWords(quantity, unit)}, ${upTo}` : errorWords(quantity, unit);
}

/** The number as a dot with its error as a whisker, on an axis from 0. */
function errorBar({ value, error }, most) {
  if (typeof error !== "object" || !(value + error.total > 0)) return null;
  const end = endOf({ value, error }, most);
  const scale = 200 / end;
  const [left, right, at] = [Math.max(0, value - error.total) * scale, end * scale, value * scale];
  const isOpen = error.total > value;
  return svg(
    "svg",
    { class: "error-bar", viewBox: "-6 -9 212 18", role: "img", "aria-label": `${within(value, error.total)} plus or minus ${number(error.total, 2)}${end < value + error.total ? `, no more than ${number(end, 2)}` : ""}` },
    svg("path", { d: "M0 0H200", class: "axis" }),
    svg("path", { d: `M${left} 0H${right}M${right} -5V5${isOpen ? "" : `M${left} -5V5`}`, class: isOpen ? "whisker open" : "whisker" }),
    svg("circle", { cx: at, cy: 0, r: 4.5 }),
  );
}
