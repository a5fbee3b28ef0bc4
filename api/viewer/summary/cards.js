// The four numbers as cards: each with its error as words and as a bar.

import { html, svg } from "../dom.js";
import { number } from "../format.js";
import { bracketed, errorWords, hasError, headline, isMiss, isResolved } from "./headline.js";
import { stoppedAt } from "./trust.js";

/** The four cards. */
export function headlineCards(summary) {
  if (isMiss(summary)) return html("section", { class: "cards", "aria-label": "Nothing touched" }, missCard(summary));
  return html("section", { class: "cards", "aria-label": "The four numbers" }, headline(summary).map((item) => card(item, summary)));
}

function missCard({ plain_words: words = [] }) {
  return html("article", { class: "card" }, html("h2", {}, "Nothing touched"), html("p", { class: "notes" }, words[0] ?? "There was no impact, and there are no numbers of one."));
}

function card({ label, unit, quantity, notes }, summary) {
  const empty = (big, words) => html("article", { class: "card" }, html("h2", {}, label), html("p", { class: "big quiet" }, big), html("p", { class: "notes" }, words));
  const stopped = stoppedAt(summary);
  if (!quantity) return empty("–", stopped ? "The run ended before it was known." : "not in this scene");
  if (summary.withheld) return empty("withheld", "The run failed a gate: no number of it is a result.");
  return html(
    "article",
    { class: "card" },
    html("h2", {}, label),
    html("p", { class: "big" }, html("span", {}, html(isResolved(quantity) ? "b" : "span", {}, bracketed(quantity)), ` ${unit} `), hasError(quantity) && html("span", { class: "error" }, errorWords(quantity, unit))),
    html("div", { class: "error-row" }, errorBar(quantity), badge(quantity)),
    html("ul", { class: "notes" }, [stopped && `only to ${stopped}, where the run ended`, ...notes].filter(Boolean).map((note) => html("li", {}, note))),
  );
}

function badge(quantity) {
  const resolved = isResolved(quantity);
  if (resolved === null) return html("span", { class: "badge warn", title: "The numerical error of this number was not estimated" }, "error not estimated");
  if (resolved) return html("span", { class: "badge good" }, "resolved");
  return html("span", { class: "badge warn", title: "The estimated error is larger than the number" }, "not resolved");
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
