// The summary in plain words, and the published injury criteria beside it: what each says, and whether it applies.

import { html, table } from "../dom.js";
import { number, setting } from "../format.js";
import { bracketed, errorWords, hasError } from "./headline.js";
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

/** The criteria: what each says, whether it says anything here, and what it is compared with; null where a summary has none. */
export function injuryCriteria({ injury_measures: measures = [], notice }) {
  if (!measures.length) return null;
  const rows = measures.map((measure) => [
    measure.title,
    measure.value == null ? "–" : `${valueOf(measure)}${unitOf(measure)}`,
    html("span", { class: measure.applicable ? "badge" : "badge warn" }, measure.applicable ? "applies" : "does not apply"),
    measure.statement,
    html("span", {}, measure.meaning, ": ", reference(measure), html("br"), html("small", {}, measure.source)),
  ]);
  const inside = table("Published criteria; what one says is no diagnosis of a person", ["criterion", "value", "validity", "what it says here", "compared with"], rows);
  return html("section", { class: "panel criteria" }, html("h2", {}, "Injury criteria"), inside, html("p", { class: "notice-line" }, notice));
}

const unitOf = ({ unit }) => (unit && unit !== "-" ? ` ${unit}` : "");

/** A value with its numerical error; one that comes of the scene alone has none. */
function valueOf({ value, error }) {
  if (error == null) return number(value, 3);
  return hasError({ error }) ? `${bracketed({ value, error })} ${errorWords({ error }, "")}` : `(${number(value, 3)}) (error ${error})`;
}

function reference(measure) {
  const [low, high] = measure.reference.map(setting);
  return `${low === high ? low : `${low} to ${high}`}${unitOf(measure)}`;
}
