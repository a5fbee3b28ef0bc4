// The four numbers as cards: each with its uncertainty as words and as a bar.

import { html, svg, term } from "../dom.js";
import { ABOUT_MARKS, within } from "../format.js";
import { headline, isMiss } from "./headline.js";
import { ABOUT_DEPTH, ABOUT_STRESS } from "./layers.js";
import { digits, errorWords, hasError, intervalOf, isResolved } from "./quantity.js";
import { stoppedAt } from "./trust.js";

/** Words in the cards that are explained. */
const TERMS = [["stress", ABOUT_STRESS], ["below the nearest surface", ABOUT_DEPTH]];

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

function card({ label, unit, quantity, limit, note }, summary) {
  const empty = (big, words) => html("article", { class: "card" }, html("h2", {}, explained(label)), html("p", { class: "big quiet" }, big), words && html("p", { class: "notes" }, words));
  if (!quantity) return empty("–", stoppedAt(summary) ? "The run ended before it was known." : "not in this scene");
  if (summary.withheld) return empty("withheld");
  return html(
    "article",
    { class: isResolved(quantity) ? "card" : "card doubtful" },
    html("h2", {}, explained(label)),
    html("p", { class: "big" }, html("span", {}, html("b", { title: (quantity.is_lower_bound || !isResolved(quantity)) && ABOUT_MARKS }, digits(quantity)), ` ${unit} `), html("span", { class: "error" }, errorOf(quantity, unit, limit))),
    errorBar(quantity),
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

/** The error in words; `limit` says what an interval ends at that ends above. */
function errorOf(quantity, unit, limit) {
  if (!hasError(quantity)) return "uncertainty not estimated";
  const words = `${isResolved(quantity) ? "" : "not resolved: "}${errorWords(quantity, unit)}`;
  return limit && intervalOf(quantity).isCutAbove ? `${words}, ${limit}` : words;
}

/** The number as a dot with its error as a whisker, on an axis from 0; an arrow where it is a lower bound. */
function errorBar(quantity) {
  if (!hasError(quantity)) return null;
  const { value } = quantity;
  const { low, high, isOpen: isBound } = intervalOf(quantity);
  const end = isBound ? value + quantity.error.total : high;
  if (!(end > 0)) return null;
  const scale = 200 / end;
  const [left, at] = [Math.max(0, low) * scale, value * scale];
  const isOpen = quantity.error.total > value;
  // A lower bound goes on above.
  const last = isBound ? "M194 -4L200 0L194 4" : "M200 -5V5";
  return svg(
    "svg",
    { class: "error-bar", viewBox: "-6 -9 212 18", role: "img", "aria-label": `${within(value, quantity.error.total)}, ${errorWords(quantity).replace("±", "plus or minus")}` },
    svg("path", { d: "M0 0H200", class: "axis" }),
    svg("path", { d: `M${left} 0H200${last}${isOpen ? "" : `M${left} -5V5`}`, class: isOpen ? "whisker open" : "whisker" }),
    svg("circle", { cx: at, cy: 0, r: 4.5 }),
  );
}
