// What happened to each layer, a sentence each: how deep, how much, above which stress.

import { html, term } from "../dom.js";
import { asSureAs, number, surenessOf } from "../format.js";
import { resultsOf, threshold } from "./headline.js";
import { hasError, isResolved, sureness } from "./quantity.js";

export const ABOUT_STRESS = "von Mises stress: how strongly the tissue is sheared at a place, as one number; a pressure from all sides does not count";

/** Depths that differ by less are the same [mm]. */
const SAME_MM = 0.5;

/** A volume as people read it. */
function volume(mm3) {
  return mm3 < 1000 ? `${number(mm3, 2)} mm³` : `${number(mm3 / 1000, 2)} cm³`;
}

/** Names of the tissue's parts, the outermost first: by the depths at which they were stressed, then as the summary lists them. */
function partsOf(tissue) {
  const first = new Map();
  for (const layer of tissue.significant_stress.flatMap(({ layers }) => layers)) {
    first.set(layer.part, Math.min(first.get(layer.part) ?? Infinity, layer.depth_mm?.[0] ?? Infinity));
  }
  const listed = (tissue.percentiles ?? []).map(({ part }) => part).reverse();
  return [...new Set([...[...first].sort((a, b) => a[1] - b[1]).map(([part]) => part), ...listed])];
}

/** Error of a depth [mm]: that of the whole region where this layer is its end; null where it is not known. */
function depthError({ depth_mm: depth, layers }, to) {
  const isEnd = layers.every((layer) => (layer.depth_mm?.[1] ?? 0) <= to);
  return isEnd && depth && hasError(depth) ? depth.error.total : null;
}

/** A depth to a millimetre; in thin layers, and near the surface, to a tenth. */
function millimetres(depth, thickness) {
  return depth.toFixed(depth < 10 && thickness < 10 ? 1 : 0);
}

/** "from 10 to 19 ± 4 mm deep"; in brackets where the error exceeds it. */
function extent(stress, [from, to]) {
  const error = depthError(stress, to);
  const end = millimetres(to, to - from);
  if (from >= SAME_MM && to - from < SAME_MM) return `only at its top, ${millimetres(from, 0)} mm deep`;
  const begin = from < SAME_MM ? "to" : `from ${millimetres(from, to - from)} to`;
  if (error == null) return `${begin} ${end} mm deep`;
  const sure = surenessOf(to, error);
  if (sure === "unresolved") return `${begin} (${end}) mm deep`;
  return `${begin} ${asSureAs(end, sure)} ± ${number(error, 1)} mm deep`;
}

/** "in 2.2 cm³ of it ± 20 %": the volume of a layer has the relative error of the whole. */
function amount({ volume_mm3: whole }, { volume_mm3: mm3 }) {
  if (!isResolved(whole)) return `(${volume(mm3)}) of it`;
  return `${asSureAs(volume(mm3), sureness(whole))} of it ±\u00a0${number((100 * whole.error.total) / whole.value, 1)}\u00a0%`;
}

/** The sentence on one layer, after its name. */
function sentence(part, tissue) {
  const rows = tissue.significant_stress.map((stress) => ({ stress, layer: stress.layers.find((layer) => layer.part === part) }));
  const reached = rows.filter(({ layer }) => layer);
  if (!reached.length) return `nowhere above ${threshold(Math.min(...rows.map(({ stress }) => stress.threshold_pa)))}.`;
  const { stress, layer } = reached.at(-1);
  const where = layer.depth_mm ? `${extent(stress, layer.depth_mm)}, ` : "";
  const first = `above ${threshold(stress.threshold_pa)} ${where}${amount(stress, layer)}`;
  const [low] = reached;
  if (low.stress === stress || !low.layer.depth_mm) return `${first}.`;
  return `${first}; above ${threshold(low.stress.threshold_pa)} ${extent(low.stress, low.layer.depth_mm)}, ${amount(low.stress, low.layer)}.`;
}

/** The sentence on the bone: it is rigid, and either the stress reaches it or ends above it; `depth_mm` of it below the surface, if it is drawn. */
function onBone(tissue, { depth_mm }) {
  if (depth_mm == null) return "a fixed surface in this model, not a solid of its own.";
  const words = `rigid in this model, ${number(depth_mm, 2)} mm deep`;
  const lowest = tissue.significant_stress[0];
  const to = Math.max(0, ...(lowest?.layers ?? []).map((layer) => layer.depth_mm?.[1] ?? 0));
  if (!lowest || to === 0) return `${words}.`;
  const above = depth_mm - to;
  if (above <= SAME_MM) return `${words}; the stress above ${threshold(lowest.threshold_pa)} reaches it.`;
  return `${words}; the stress above ${threshold(lowest.threshold_pa)} ends ${number(above, 2)} mm before it.`;
}

/** The sentences on all layers, with the `bone` {depth_mm} where there may be one; null where nothing is known of the tissue. */
export function layerSentences(summary, bone = null) {
  const { tissue } = resultsOf(summary);
  if (!tissue?.significant_stress?.length || summary.withheld) return null;
  const parts = partsOf(tissue);
  // The part of a tissue of one part is called by what the mesh is: a block.
  const [title, names] = parts.length > 1 ? ["What happened to each layer", parts] : ["What happened to the tissue", ["tissue"]];
  const item = (name, words) => html("li", {}, html("b", {}, name), " ", words);
  const sentences = parts.map((part) => sentence(part, tissue));
  const remark = sentences.some((words) => words.includes("(")) && "; in brackets: not resolved, or of unknown error";
  return html(
    "section",
    { class: "layers", "aria-label": title },
    html("h2", {}, `${title} `, html("small", {}, term("stress", ABOUT_STRESS), ", at its largest", remark || "")),
    html("ul", {}, sentences.map((words, i) => item(names[i], words)), bone && !parts.includes("bone") ? item("bone", onBone(tissue, bone)) : null),
  );
}
