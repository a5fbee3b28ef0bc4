// The published injury criteria: what each says, and whether it applies.

import { html, table } from "../dom.js";
import { setting } from "../format.js";
import { stoppedAt } from "./trust.js";

/** What a verdict of the scene alone is not, where the run gives no result. */
const OF_THE_SCENE = "from the scene alone: the run itself gives no result";

/** The criteria: what each says, and what it is compared with; those that do not apply are collapsed. Null where a summary has none. */
export function injuryCriteria(summary) {
  const { injury_measures: measures = [], notice } = summary;
  if (!measures.length) return null;
  const isStopped = stoppedAt(summary) != null;
  const [applicable, others] = [true, false].map((applies) => measures.filter((measure) => measure.applicable === applies));
  // What a criterion says has its value with its error, and what that is compared with.
  const rows = applicable.map((measure) => [
    measure.title, statementOf(measure, isStopped), html("span", {}, measure.meaning, html("br"), html("small", {}, measure.source)),
  ]);
  const item = (measure) => html("li", {}, html("b", {}, measure.title), ` ${measure.statement} (${measure.meaning}: ${reference(measure)}; ${measure.source})`);
  return html(
    "section",
    { class: "panel criteria" },
    html("h2", {}, "Injury criteria"),
    rows.length ? table("Published criteria that apply to this impact", ["criterion", "what it says here", "compared with"], rows) : html("p", {}, "No published criterion applies to this impact."),
    others.length ? html("details", {}, html("summary", {}, `${others.length} that ${others.length > 1 ? "do" : "does"} not apply, and why`), html("ul", {}, others.map(item))) : null,
    html("p", { class: "notice-line" }, notice),
  );
}

/** What a measure says. Of a run that ended early the program remarks only what comes of the run itself. */
function statementOf({ statement, error, value }, isStopped) {
  const isOfTheScene = value != null && error == null;
  return isStopped && isOfTheScene && !statement.includes(OF_THE_SCENE) ? `${statement} (${OF_THE_SCENE})` : statement;
}

function reference({ reference: ends, unit }) {
  const [low, high] = ends.map(setting);
  return `${low === high ? low : `${low} to ${high}`}${unit && unit !== "-" ? ` ${unit}` : ""}`;
}
