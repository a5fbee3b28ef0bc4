// The clinical summary: four numbers with their errors, the gates, the warnings, and everything else in a table.

import { button, html, svg, table } from "./dom.js";
import { number, withUnit } from "./format.js";

/** The impact that the four numbers speak of: the hardest of those on the tissue. */
export function mainImpact(results) {
  const impacts = results.impacts ?? [];
  const onTissue = impacts.filter((impact) => impact.on_tissue);
  const among = onTissue.length ? onTissue : impacts;
  return among.reduce((best, impact) => (!best || impact.peak_force_n.value > best.peak_force_n.value ? impact : best), null);
}

/** The numbers of a summary, plain or withheld. */
export function resultsOf(summary) {
  return summary.results ?? summary.withheld?.values ?? { impacts: [] };
}

/** The four numbers: {label, unit, quantity, notes}. Absent where the scene has no contact or no tissue. */
export function headline(summary) {
  const results = resultsOf(summary);
  const impact = mainImpact(results);
  const { tissue } = results;
  const stresses = (tissue?.significant_stress ?? []).filter((stress) => stress.depth_mm);
  const deepest = stresses.at(-1);
  const axes = impact && [impact.patch_long_axis_mm, impact.patch_short_axis_mm].map((axis) => number(axis.value, 3));
  return [
    {
      label: "Peak impact force",
      unit: "N",
      quantity: impact?.peak_force_n,
      notes: impact && [`mean over ${impact.force_window_s * 1e6} µs, at ${number(impact.peak_force_time_s.value * 1e6)} µs`, `impulse ${withUnit(impact.impulse_n_s.value, "N s")}`],
    },
    {
      label: "Contact patch",
      unit: "mm²",
      quantity: impact?.patch_area_mm2,
      notes: impact && [`${axes.join(" × ")} mm, at the peak force`, `largest ${withUnit(impact.largest_patch_area_mm2.value, "mm²")}`],
    },
    {
      label: "Depth of significant stress",
      unit: "mm",
      quantity: deepest?.depth_mm,
      notes: deepest && [
        `von Mises above ${withUnit(deepest.threshold_pa / 1e3, "kPa", 3)}`,
        ...stresses.slice(0, -1).reverse().map((s) => `above ${withUnit(s.threshold_pa / 1e3, "kPa", 3)}: ${bracketed(s.depth_mm)} mm`),
      ],
    },
    {
      label: "Absorbed energy",
      unit: "J",
      quantity: tissue?.absorbed_energy_j,
      notes: tissue && [
        tissue.contact_ended ? "when contact had ended" : "at the end; contact has not ended",
        ...(tissue.projectile_loss_j ? [`of ${withUnit(tissue.projectile_loss_j.value, "J")} that the projectile lost`] : []),
      ],
    },
  ];
}

/** Whether a number is larger than its error; null when nobody knows. */
function isResolved(quantity) {
  return typeof quantity.error === "object" ? quantity.error.resolved : null;
}

/** A number; in brackets when its error is larger. */
export function bracketed(quantity) {
  return isResolved(quantity) === false ? `(${number(quantity.value)})` : number(quantity.value);
}

/** A quantity with its error in words. */
export function errorWords(quantity, unit) {
  if (typeof quantity.error !== "object") return String(quantity.error);
  return `± ${withUnit(quantity.error.total, unit, 2)}`;
}

/** The four cards. */
export function headlineCards(summary) {
  const isWithheld = Boolean(summary.withheld);
  return html("section", { class: "cards", "aria-label": "The four numbers" }, headline(summary).map((item) => card(item, isWithheld)));
}

function card({ label, unit, quantity, notes }, isWithheld) {
  if (!quantity) {
    return html("article", { class: "card" }, html("h2", {}, label), html("p", { class: "big quiet" }, "–"), html("p", { class: "notes" }, "not in this scene"));
  }
  if (isWithheld) {
    return html("article", { class: "card" }, html("h2", {}, label), html("p", { class: "big quiet" }, "withheld"), html("p", { class: "notes" }, "The run failed a gate: no number of it is a result."));
  }
  const resolved = isResolved(quantity);
  const badge = resolved === false
    ? html("span", { class: "badge warn", title: "The estimated error is larger than the number" }, "not resolved")
    : resolved === null ? html("span", { class: "badge" }, "error not estimated") : html("span", { class: "badge good" }, "resolved");
  return html(
    "article",
    { class: "card" },
    html("h2", {}, label),
    html("p", { class: "big" }, html("b", {}, bracketed(quantity)), ` ${unit} `, html("span", { class: "error" }, errorWords(quantity, unit))),
    html("div", { class: "error-row" }, errorBar(quantity), badge),
    html("ul", { class: "notes" }, notes.map((note) => html("li", {}, note))),
  );
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

/** The verdict in one line, beside the numbers; `onclick` leads to the whole. */
export function trustLine(summary, onclick) {
  const failed = summary.gates.filter((gate) => gate.result !== "passed").length;
  const count = summary.gates.length;
  const verdict = failed
    ? html("span", { class: "badge bad" }, `✗ ${failed} of ${count} gates failed`)
    : html("span", { class: "badge good" }, `✓ all ${count} gates passed`);
  const { warnings } = summary;
  const words = warnings.length ? html("span", {}, html("span", { class: "badge warn" }, `${warnings.length} ${warnings.length > 1 ? "warnings" : "warning"}`), ` ${warnings[0]}`) : html("span", { class: "quiet" }, "no warnings");
  return html("div", { class: "trust-line" }, verdict, words, button("Can these numbers be trusted?", onclick));
}

/** Gates, warnings and where the errors come from. */
export function trustPanel(summary) {
  const gates = summary.gates.map((gate) =>
    html("li", { class: gate.result === "passed" ? "gate good" : "gate bad" },
      html("b", {}, `${gate.result === "passed" ? "✓ passed" : "✗ failed"} `), `${gate.meaning}: ${number(gate.value, 2)} (limit ${number(gate.limit, 2)})`),
  );
  return html(
    "section",
    { class: "panel trust" },
    html("h2", {}, "Can these numbers be trusted?"),
    summary.withheld && html("p", { class: "alert" }, `Results are withheld: ${summary.withheld.reason}`),
    html("ul", { class: "gates" }, gates),
    summary.warnings.length ? html("ul", { class: "warnings" }, summary.warnings.map((w) => html("li", {}, w))) : html("p", { class: "quiet" }, "No warnings."),
    html("p", { class: "quiet" }, `Error bars: ${summary.error_bars}.`),
    html("p", { class: "quiet" }, summary.notice),
  );
}

/** What the error of a number is made of. */
const ERROR_PARTS = ["mesh", "step", "contact", "resolution"];

/** Every number of the summary as a table. */
export function allNumbers(summary) {
  const rows = [];
  const walk = (path, value) => {
    if (value && typeof value === "object" && "value" in value && "error" in value) {
      const words = path.join(" › ").replaceAll("_", " ");
      const parts = typeof value.error === "object" ? ["total", ...ERROR_PARTS].map((k) => number(value.error[k], 2)) : [value.error, ...ERROR_PARTS.map(() => "")];
      rows.push([words, summary.withheld ? "withheld" : bracketed(value), ...parts]);
    } else if (value && typeof value === "object") {
      for (const [key, inner] of Object.entries(value)) {
        const name = Array.isArray(value) ? inner?.pair ?? (inner?.threshold_pa ? `${inner.threshold_pa / 1e3} kPa` : key) : key;
        walk([...path, name], inner);
      }
    }
  };
  walk([], resultsOf(summary));
  return table("Every number, with the parts of its error; units are the ends of the names", ["number", "value", "± error", ...ERROR_PARTS], rows);
}
