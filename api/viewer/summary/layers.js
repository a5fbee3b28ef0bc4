// What happened to each layer, a sentence each: how deep, how much, above which stress.

import { html, term } from "../dom.js";
import { exceeds, marked, number, within } from "../format.js";
import { isLeast, resultsOf, threshold } from "./headline.js";
import { errorWords, hasError, intervalOf, isResolved } from "./quantity.js";

export const ABOUT_STRESS = "von Mises stress: how strongly the tissue is sheared at a place, as one number; a pressure from all sides does not count";

export const ABOUT_DEPTH = "distance of a place from the nearest point of the surface, both as they were before the impact";

/** Depths that differ by less are the same [mm]. */
const SAME_MM = 0.5;

/** Names of the tissue's parts, the outermost first: by the depths at which they were stressed, then as the summary lists them. */
function partsOf(tissue) {
  const first = new Map();
  for (const layer of tissue.significant_stress.flatMap(({ layers }) => layers)) {
    first.set(layer.part, Math.min(first.get(layer.part) ?? Infinity, layer.depth_mm?.[0] ?? Infinity));
  }
  const listed = (tissue.percentiles ?? []).map(({ part }) => part).reverse();
  return [...new Set([...[...first].sort((a, b) => a[1] - b[1]).map(([part]) => part), ...listed])];
}

/** Whether a layer is the end of the region above a stress: then the error of the depth is that of its end. */
function isEnd({ layers }, to) {
  return layers.every((layer) => (layer.depth_mm?.[1] ?? 0) <= to);
}

/** A depth to a millimetre; in thin layers, and near the surface, to a tenth. */
function millimetres(depth, thickness) {
  return depth.toFixed(depth < 10 && thickness < 10 ? 1 : 0);
}

/** "from 10.2 to 19.1 ± 4.2 mm deep"; in brackets where the error is as large, or not known; "at least" where it is a lower bound. */
function extent(stress, [from, to]) {
  if (from >= SAME_MM && to - from < SAME_MM) return `only at its top, ${millimetres(from, 0)} mm deep`;
  const { depth_mm: depth } = stress;
  const begin = (words) => (from < SAME_MM ? "to" : `from ${words} to`);
  if (!isEnd(stress, to) || !depth) return `${begin(millimetres(from, to - from))} ${millimetres(to, to - from)} mm deep`;
  const least = isLeast(depth) ? "at least " : "";
  const error = hasError(depth) ? depth.error.total : null;
  if (error == null || !exceeds(to, error)) return `${begin(millimetres(from, to - from))} ${least}(${millimetres(to, to - from)}) mm deep`;
  const [first, last] = [begin(within(from, error)), `${least}${within(to, error)}`];
  // Not deeper than the tissue.
  return intervalOf(depth).isCutAbove ? `${first} ${last} mm deep (${errorWords(depth, "mm")})` : `${first} ${last} ± ${number(error, 2)} mm deep`;
}

/**
 * "in 2.2 cm³ of it": to the digits that the error of the volume of all layers leaves, since a layer has none of its own; a lower bound where that is one.
 * In brackets where that error is as large as the volume, or not known, as in the report.
 */
function amount({ volume_mm3: whole }, { volume_mm3: mm3 }) {
  const [size, unit, scale] = mm3 < 1000 ? [mm3, "mm³", 1] : [mm3 / 1000, "cm³", 1000];
  const error = hasError(whole) ? whole.error.total : null;
  const isKnown = error != null && whole.error.resolved && error < mm3;
  return `in ${marked(within(size, error / scale), isKnown, isLeast(whole))} ${unit} of it`;
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

/** The sentence on the bone: it is rigid, and either the stress reaches it or ends above it; `depth_mm` of it below the impact, if it is drawn. */
function onBone(tissue, { depth_mm }) {
  if (depth_mm == null) return "a fixed surface in this model, not a solid of its own.";
  const words = `rigid in this model, ${number(depth_mm, 2)} mm deep below the impact`;
  const lowest = tissue.significant_stress[0];
  const to = Math.max(0, ...(lowest?.layers ?? []).map((layer) => layer.depth_mm?.[1] ?? 0));
  if (!lowest || to === 0) return `${words}.`;
  const [above, error] = [depth_mm - to, lowest.depth_mm?.error?.total];
  const stress = `the stress above ${threshold(lowest.threshold_pa)}`;
  if (lowest.reaches?.some((end) => end.startsWith("the held nodes"))) return `${words}; ${stress} reaches it.`;
  if (above <= Math.max(SAME_MM, error ?? 0)) return `${words}; whether ${stress} reaches it is not resolved.`;
  if (isLeast(lowest.depth_mm)) return `${words}; ${stress} has not reached it when the run ends, and may later.`;
  return `${words}; ${stress} ends ${error > 0 ? `${within(above, error)} ± ${number(error, 2)}` : `(${number(above, 2)})`} mm before it.`;
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
    html("h2", {}, `${title} `, html("small", {}, term("stress", ABOUT_STRESS), " and ", term("depth", ABOUT_DEPTH), " at their largest", remark || "")),
    html("ul", {}, sentences.map((words, i) => item(names[i], words)), bone && !parts.includes("bone") ? item("bone", onBone(tissue, bone)) : null),
  );
}
