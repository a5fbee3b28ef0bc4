// The results of a study: error against run time of one scene, or the matrix of stiff and extreme cases.

import { button, html, saveFile, select, table } from "../dom.js";
import { number, setting, withUnit } from "../format.js";
import { errorCost } from "../plots/error_cost.js";

/** How a cell of the matrix ended, as a kind of badge. */
const VERDICTS = { finished: "good", diagnosed: "warn", refused: "warn", wrong: "bad" };

/** A study as pictures and tables, and as JSON to take along. */
export function studyResults(name, study) {
  const parts = study.cells ? stabilityParts(study) : study.rows ? errorParts(study) : [];
  const save = () => saveFile(`${name}.json`, JSON.stringify(study, null, 2), "application/json");
  return html(
    "section",
    { class: "panel study", "aria-label": "Results of the study" },
    study.stopped && html("p", { class: "alert" }, `Stopped before its end (${study.stopped}): what is missing was not computed.`),
    parts,
    html("div", { class: "tools" }, button("Results (JSON)", save)),
  );
}

const percent = (fraction) => withUnit(100 * fraction, "%", 2);
const seconds = (value) => withUnit(value, "s", 2);
const cost = ({ cpu_s, wall_s }) => cpu_s ?? wall_s;

/** What a study calls a number: its title with the unit. */
function titleIn({ quantities }, quantity) {
  if (!quantity) return "all numbers";
  const { title, unit } = quantities[quantity];
  return unit === "-" ? title : `${title} [${unit}]`;
}

/** The name of a setting, its mesh in words. */
export function settingWords(name) {
  return name.replace(/^mesh ([+-]?)(\d*)(½?)/, (_, sign, whole, half) => {
    const level = Number(whole || 0) + (half ? 0.5 : 0);
    return level === 0 ? "mesh as given" : `mesh ${setting(Number((2 ** level).toPrecision(2)))} × ${sign === "-" ? "coarser" : "finer"}`;
  });
}

/** Whether a setting differs from the scene's own by its mesh alone. */
const isOfMesh = ({ setting: { mesh_level: _, mesh_factor: __, step_divisor: steps, ...others } }) => steps === 1 && !Object.keys(others).length;

function errorParts(study) {
  const quantities = Object.keys(study.references);
  const rows = study.rows.map((row) => [settingWords(row.name), row.elements, row.steps, seconds(cost(row)), ...quantities.map((quantity) => errorCell(row, quantity))]);
  const columns = ["setting", "elements", "steps", "processor time", ...quantities.map((quantity) => titleIn(study, quantity))];
  return [
    errorPlots(study, quantities),
    study.advice.length ? cheapest(study) : null,
    html("details", {}, html("summary", {}, "All settings and limits as tables"),
      table("Settings: each number, and in brackets its error against the limit", columns, rows),
      table("Limits: what errors are measured against", ["number", "value", "uncertainty", "what it is"], quantities.map((quantity) => limitRow(titleIn(study, quantity), study.references[quantity]))),
      study.geometry && geometry(study)),
    study.rows.filter(({ reason }) => reason).map(({ name, reason }) => html("p", { class: "quiet" }, `${settingWords(name)}: ${reason}`)),
  ];
}

/** Error against processor time of one number at a time; null where no error is known. */
function errorPlots(study, quantities) {
  const pointsOf = (quantity) => study.rows.filter(({ ending, errors }) => ending === "finished" && errors[quantity] != null)
    .map((row) => ({ name: settingWords(row.name), cost: cost(row), error: Math.abs(row.errors[quantity]), isMesh: isOfMesh(row) }));
  const shown = quantities.filter((quantity) => pointsOf(quantity).length);
  if (!shown.length) return html("p", { class: "quiet" }, "No limit is known well enough for errors to be drawn.");
  const holder = html("div", { class: "error-plot" });
  const draw = (quantity) => {
    const { value, uncertainty } = study.references[quantity];
    const known = uncertainty > 0 && value ? Math.abs(uncertainty / value) : null;
    holder.replaceChildren(errorCost(pointsOf(quantity), known, titleIn(study, quantity)));
  };
  draw(shown[0]);
  return html("div", {}, html("h2", {}, "Error against run time"), select("Number", shown.map((quantity) => [quantity, titleIn(study, quantity)]), shown[0], draw), holder,
    html("p", { class: "quiet" }, "Line: the scene's own settings on meshes from coarse to fine. Other points: other settings on one of them. Lower is more accurate, further left is cheaper."));
}

function errorCell({ ending, values, errors }, quantity) {
  if (ending !== "finished") return ending.replaceAll("_", " ");
  if (values[quantity] == null) return "–";
  const [value, error] = [values[quantity], errors[quantity]];
  if (error == null) return `${number(value)} (error unknown)`;
  return `${Math.abs(error) < 1 ? number(value) : `(${number(value)})`} (${percent(error)})`;
}

/** The cheapest setting for each number and each error that must not be exceeded. */
function cheapest(study) {
  const { advice } = study;
  const targets = [...new Set(advice.map(({ target }) => target))];
  const choice = (one) => (one?.setting ? `${settingWords(one.setting)}, ${seconds(one.cost_s)}` : "none of these");
  const quantities = [...new Set(advice.map(({ quantity }) => quantity))];
  const rows = quantities.map((quantity) => [
    titleIn(study, quantity),
    ...targets.map((target) => choice(advice.find((one) => one.quantity === quantity && one.target === target))),
  ]);
  return table("Cheapest setting, the uncertainty of the limit included", ["number", ...targets.map((target) => `for ${setting(100 * target)} %`)], rows);
}

function limitRow(title, { kind, value, uncertainty, order, meshes, reason }) {
  const words = {
    exact: "exact",
    extrapolated: `limit of the meshes, observed order ${number(order, 3)}`,
    given: "another code",
    fitted: `limit of a line through ${meshes} meshes`,
    finest: `the finest mesh, since ${reason}`,
    unknown: `no reference, since ${reason}`,
  };
  return [title, number(value), uncertainty == null ? "–" : `± ${number(uncertainty, 2)}`, words[kind] ?? kind];
}

function geometry(study) {
  const rows = Object.entries(study.geometry).map(([quantity, { change, change_by_surface: bySurface, error }]) => [titleIn(study, quantity), ...[change, bySurface, error].map(percent)]);
  const columns = ["number", "change to the mesh twice as fine", "due to the surface", "error of the mesh as given due to facets"];
  return table("Geometry: effect of facets in place of the true surface, second order assumed", columns, rows);
}

function stabilityParts({ cells, physical, physical_finished: finished, wrong }) {
  const rows = cells.map(({ axis, value, stepping, verdict, reason, remedy }) => [
    axis, value, steppingWords(stepping), html("span", { class: `badge ${VERDICTS[verdict] ?? ""}` }, verdict), reason ?? "", remedy ?? "",
  ]);
  return [
    html("p", {}, `${cells.length} cases. Of ${physical} physical ones ${finished} finish within their limits; ${wrong} ended without a diagnosis.`),
    matrix(cells),
    html("details", {}, html("summary", {}, "All cells as a table, with reasons and remedies"), table("Stiff and extreme cases", ["axis", "value", "stepping", "verdict", "reason", "remedy"], rows)),
  ];
}

/** The cells as a picture: a row for each axis and stepping, a field for each value, coloured by how it ended. */
function matrix(cells) {
  const isOne = new Set(cells.map(({ stepping }) => steppingWords(stepping))).size === 1;
  const rows = Map.groupBy(cells, ({ axis, stepping }) => (isOne ? axis : `${axis}, ${steppingWords(stepping)}`));
  const field = ({ value, verdict, reason }) => html("li", { class: `field-of-matrix ${VERDICTS[verdict] ?? ""}`, title: reason ?? "" }, html("b", {}, value), html("span", {}, verdict));
  return html("div", { class: "matrix", role: "group", "aria-label": "How each case ended" },
    [...rows].map(([name, fields]) => html("div", { class: "row-of-matrix" }, html("span", {}, name), html("ul", {}, fields.map(field)))));
}

function steppingWords(stepping) {
  return stepping.implicit ? `implicit, step × ${stepping.implicit.step_ratio}` : stepping;
}
