// The summary in plain words, and the published injury criteria beside it: what each says, and whether it covers this scene.

import { html, table } from "../dom.js";
import { number, setting } from "../format.js";
import { stoppedAt } from "./trust.js";

/** The sentences; null where a summary has none. */
export function plainWords(summary) {
  const { plain_words: words = [] } = summary;
  if (!words.length) return null;
  const stopped = stoppedAt(summary);
  return html(
    "section",
    { class: "panel plain-words", "aria-label": "In plain words" },
    html("h2", {}, "In plain words"),
    stopped && html("p", { class: "alert" }, `The run ended at ${stopped}, before its end: these are no final results.`),
    html("ul", {}, words.map((sentence) => html("li", {}, sentence))),
    html("p", { class: "notice-line" }, summary.notice),
  );
}

/** The criteria: what each says, whether it covers this scene, and what it is compared with; null where a summary has none. */
export function injuryCriteria({ injury_measures: measures = [], notice }) {
  if (!measures.length) return null;
  const rows = measures.map((measure) => [
    measure.title,
    measure.value == null ? "–" : `${number(measure.value, 3)}${errorOf(measure)}${unitOf(measure)}`,
    html("span", { class: measure.applicable ? "badge" : "badge warn" }, measure.applicable ? "covers this scene" : "does not apply"),
    measure.statement,
    html("span", {}, measure.meaning, ": ", reference(measure), html("br"), html("small", {}, measure.source)),
  ]);
  const inside = table("Published criteria; what one says is no diagnosis of a person", ["criterion", "value", "validity", "what it says here", "compared with"], rows);
  return html("section", { class: "panel criteria" }, html("h2", {}, "Injury criteria"), inside, html("p", { class: "notice-line" }, notice));
}

const unitOf = ({ unit }) => (unit && unit !== "-" ? ` ${unit}` : "");

/** The error of a value, if it comes with one: a number, or the parts of a quantity. */
function errorOf({ error }) {
  const total = typeof error === "object" ? error?.total : error;
  return Number.isFinite(total) ? ` ± ${number(total, 2)}` : "";
}

function reference(measure) {
  const [low, high] = measure.reference.map(setting);
  return `${low === high ? low : `${low} to ${high}`}${unitOf(measure)}`;
}
