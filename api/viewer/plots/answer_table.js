// The points and the curves of an answer as a table and as comma-separated text, with the ends of their bands.

import { button, html, saveFile, table } from "../dom.js";
import { bracketed, commaSeparated, setting, within } from "../format.js";
import { isKnownAt, sampled } from "./crossing.js";

/** Steps between the proposed speeds of a curve in the text. */
const PROPOSED = 60;

/** Where the number of a computed point is from, in words. */
const originOf = ({ error, least }) => `computed${error == null ? ", error unknown" : ""}${least ? `, a lower bound: ${least}` : ""}`;

/** Where the number of a curve is from, in words; `isKnown` where its error is. */
const originOfCurve = ({ isLeast }, isKnown) => `proposed${isKnown ? "" : ", error unknown"}${isLeast ? ", a lower bound" : ""}`;

/** The ends of a computed point: none where its error is not known, no upper one of a lower bound. */
const endsOf = ({ error, lower, upper, least }) => [error == null ? null : lower, error == null || least ? null : upper];

/** The rows of a series: [name, speed, number, from, to, origin], the computed ones first; nothing is known above a lower bound. */
function rowsOf({ name, points, curve }) {
  const computed = points.map((point) => [name, point.speed, point.value, ...endsOf(point), originOf(point)]);
  if (!curve) return computed;
  const proposed = sampled(curve.value, curve.range, PROPOSED).map(([speed, value]) => {
    const isKnown = isKnownAt(curve, speed);
    const ends = isKnown ? [curve.lower(speed), curve.isLeast ? null : curve.upper(speed)] : [null, null];
    return [name, speed, value, ...ends, originOfCurve(curve, isKnown)];
  });
  return [...computed, ...proposed];
}

/** The whole answer as comma-separated text. */
export function answerCsv({ series, axis }) {
  const head = ["curve", "speed [m/s]", `${axis.label} [${axis.unit}]`, `from [${axis.unit}]`, `to [${axis.unit}]`, "origin"];
  return commaSeparated([head, ...series.flatMap(rowsOf)]);
}

/** The computed points as a table that can be opened, and a button for the text. */
export function answerTable(answer, isOpen) {
  const { series, axis } = answer;
  const row = (name, point) => {
    const { speed, value, error, least } = point;
    const ends = endsOf(point).map((end) => (end == null ? "–" : within(end, error)));
    return [name, setting(speed), bracketed(value, error, Boolean(least)), ...ends, originOf(point)];
  };
  const rows = series.flatMap(({ name, points }) => points.map((point) => row(name, point)));
  const caption = `${axis.label}, with its numerical error within what is possible`;
  const columns = ["curve", "speed [m/s]", `number [${axis.unit}]`, `from [${axis.unit}]`, `to [${axis.unit}]`, ""];
  return html(
    "div",
    {},
    button("CSV", () => saveFile("answer.csv", answerCsv(answer), "text/csv"), { "aria-label": "Answer as CSV" }),
    html("details", { class: "numbers", open: isOpen }, html("summary", {}, "Table"), table(caption, columns, rows)),
  );
}
