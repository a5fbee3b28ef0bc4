// The results of a study: error against run time of one scene, or the matrix of stiff and extreme cases.

import { button, html, saveFile, table } from "../dom.js";
import { bracketed, number, setting, withUnit } from "../format.js";

/** How a cell of the matrix ended, as a kind of badge. */
const VERDICTS = { finished: "good", diagnosed: "warn", refused: "warn", wrong: "bad" };

/** A study as tables, and as JSON to take along. */
export function studyResults(name, study) {
  const tables = study.cells ? stabilityTables(study) : study.rows ? errorTables(study) : [];
  const save = () => saveFile(`${name}.json`, JSON.stringify(study, null, 2), "application/json");
  return html(
    "section",
    { class: "panel study", "aria-label": "Results of the study" },
    study.stopped && html("p", { class: "alert" }, `Stopped before its end (${study.stopped}): what is missing was not computed.`),
    tables,
    html("div", { class: "tools" }, button("Results (JSON)", save)),
  );
}

const percent = (fraction) => withUnit(100 * fraction, "%", 2);
const seconds = (value) => withUnit(value, "s", 2);
/** A quantity in words; its unit is the end of its name. */
const quantityWords = (quantity) => quantity?.replaceAll("_", " ") ?? "headline numbers";

function errorTables(study) {
  const quantities = Object.keys(study.references);
  const cost = ({ cpu_s, wall_s }) => seconds(cpu_s ?? wall_s);
  const rows = study.rows.map((row) => [row.name, row.elements, row.steps, cost(row), ...quantities.map((quantity) => errorCell(row, quantity))]);
  const columns = ["setting", "elements", "steps", "processor time", ...quantities.map(quantityWords)];
  return [
    table("Settings: each number, and in brackets its error against the limit; units are the ends of the names", columns, rows),
    study.advice.length ? cheapest(study.advice) : null,
    table("Limits: what errors are measured against", ["number", "value", "uncertainty", "what it is"], quantities.map((quantity) => limitRow(quantity, study.references[quantity]))),
    study.geometry && geometry(study.geometry),
    study.rows.filter(({ reason }) => reason).map(({ name, reason }) => html("p", { class: "quiet" }, `${name}: ${reason}`)),
  ];
}

function errorCell({ ending, values, errors }, quantity) {
  if (ending !== "finished") return ending.replaceAll("_", " ");
  if (values[quantity] == null) return "–";
  const [value, error] = [values[quantity], errors[quantity]];
  if (error == null) return `${number(value)} (error unknown)`;
  return `${bracketed(value, Math.abs(error * value))} (${percent(error)})`;
}

/** The cheapest setting for each number and each error that must not be exceeded. */
function cheapest(advice) {
  const targets = [...new Set(advice.map(({ target }) => target))];
  const choice = (one) => (one?.setting ? `${one.setting}, ${seconds(one.cost_s)}` : "none of these");
  const quantities = [...new Set(advice.map(({ quantity }) => quantity))];
  const rows = quantities.map((quantity) => [
    quantityWords(quantity),
    ...targets.map((target) => choice(advice.find((one) => one.quantity === quantity && one.target === target))),
  ]);
  return table("Cheapest setting, the uncertainty of the limit included", ["number", ...targets.map((target) => `for ${setting(100 * target)} %`)], rows);
}

function limitRow(quantity, { kind, value, uncertainty, order, meshes, reason }) {
  const words = {
    exact: "exact",
    extrapolated: `limit of the meshes, observed order ${number(order, 3)}`,
    given: "another code",
    fitted: `limit of a line through ${meshes} meshes`,
    finest: `the finest mesh, since ${reason}`,
    unknown: `no reference, since ${reason}`,
  };
  return [quantityWords(quantity), number(value), uncertainty == null ? "–" : `± ${number(uncertainty, 2)}`, words[kind] ?? kind];
}

function geometry(changes) {
  const rows = Object.entries(changes).map(([quantity, { change, change_by_surface: bySurface, error }]) => [quantityWords(quantity), ...[change, bySurface, error].map(percent)]);
  const columns = ["number", "change from mesh 0 to mesh +1", "due to the surface", "error of mesh 0 due to facets"];
  return table("Geometry: effect of facets in place of the true surface, second order assumed", columns, rows);
}

function stabilityTables({ cells, physical, physical_finished: finished, wrong }) {
  const rows = cells.map(({ axis, value, stepping, verdict, reason, remedy }) => [
    axis, value, steppingWords(stepping), html("span", { class: `badge ${VERDICTS[verdict] ?? ""}` }, verdict), reason ?? "", remedy ?? "",
  ]);
  return [
    html("p", {}, `${cells.length} cells. Of ${physical} physical ones ${finished} finish within their limits; ${wrong} ended without a diagnosis.`),
    table("Stiff and extreme cases", ["axis", "value", "stepping", "verdict", "reason", "remedy"], rows),
  ];
}

function steppingWords(stepping) {
  return stepping.implicit ? `implicit, step × ${stepping.implicit.step_ratio}` : stepping;
}
