// What a summary says first: the hardest impact, the four numbers, and numbers with their errors as words.

import { number, setting, withUnit } from "../format.js";

/** The numbers of a summary, plain or withheld. */
export function resultsOf(summary) {
  return summary.results ?? summary.withheld?.values ?? { impacts: [] };
}

/** The impact that the four numbers speak of: the one that the summary names, else the hardest of those on the tissue. */
export function mainImpact(results) {
  const impacts = results.impacts ?? [];
  if (results.headline?.impact != null) return impacts[results.headline.impact];
  const onTissue = impacts.filter((impact) => impact.on_tissue);
  const among = onTissue.length ? onTissue : impacts;
  const force = (impact) => impact.peak_force_n?.value ?? 0;
  return among.reduce((best, impact) => (!best || force(impact) > force(best) ? impact : best), null);
}

/** Whether nothing touched in a run: then none of its numbers is of an impact. */
export function isMiss(summary) {
  return resultsOf(summary).nothing_touched === true;
}

/** Whether a number is larger than its error; null when its error was not estimated. */
export function isResolved(quantity) {
  return hasError(quantity) ? quantity.error.resolved : null;
}

/** Whether the error of a number was estimated. */
export function hasError(quantity) {
  return quantity.error != null && typeof quantity.error === "object";
}

/** A number; in brackets when its error is larger, or was not estimated. */
export function bracketed(quantity) {
  return isResolved(quantity) ? number(quantity.value) : `(${number(quantity.value)})`;
}

/** The error of a number in words. */
export function errorWords(quantity, unit) {
  if (!hasError(quantity)) return String(quantity.error ?? "not estimated");
  return `± ${withUnit(quantity.error.total, unit, 2)}`;
}

/** A number with its error and its unit, in one phrase. */
function phrase(quantity, unit) {
  return hasError(quantity) ? `${bracketed(quantity)} ${errorWords(quantity, unit)}` : `${bracketed(quantity)}\u202f${unit}`;
}

/** A threshold of stress. */
export function threshold(pascal) {
  return `${setting(pascal / 1e3)} kPa`;
}

/** The stress whose depth stands for all: the one that the summary names, else that of the first threshold of the scene. */
function significant({ headline, tissue }) {
  const stresses = tissue?.significant_stress ?? [];
  const main = stresses[headline?.significant_stress ?? 0];
  return { main, others: stresses.filter((stress) => stress !== main) };
}

/** The threshold [Pa] that the depth of stress is above; null where there is none. */
export function significantThreshold(summary) {
  return significant(resultsOf(summary)).main?.threshold_pa ?? null;
}

/** The four numbers: {label, unit, quantity, notes}. Absent where the scene has no contact or no tissue, or the run did not get there. */
export function headline(summary) {
  const results = resultsOf(summary);
  const impact = mainImpact(results);
  const { tissue } = results;
  return [
    { label: "Peak impact force", unit: "N", quantity: impact?.peak_force_n, notes: impact && forceNotes(impact) },
    { label: "Largest contact patch", unit: "mm²", quantity: impact?.largest_patch_area_mm2, notes: impact && patchNotes(impact) },
    depth(results),
    { label: "Energy given to the tissue", unit: "J", quantity: tissue?.energy_given_j, notes: tissue && energyNotes(tissue) },
  ];
}

/** A note, if its number is there. That errors are not estimated is said once, beside the number of the card, unless that has one. */
function note(words, quantity, unit, card) {
  if (!quantity) return [];
  const doubt = !hasError(quantity) && card && hasError(card) ? " (error not estimated)" : "";
  return [`${words} ${phrase(quantity, unit)}${doubt}`];
}

function forceNotes(impact) {
  const { peak_force_n: card, peak_force_time_s: time } = impact;
  return [...note(`${impact.force_average}, at`, time && times(time, 1e6), "µs", card), ...note("impulse", impact.impulse_n_s, "N s", card)];
}

/** A quantity in another unit. */
function times(quantity, factor) {
  const error = hasError(quantity) ? { ...quantity.error, total: quantity.error.total * factor } : quantity.error;
  return { ...quantity, value: quantity.value * factor, error };
}

function patchNotes(impact) {
  const { largest_patch_area_mm2: card } = impact;
  return [
    ...note("mean over the window of the peak force:", impact.patch_area_mm2, "mm²", card),
    ...note("long axis", impact.patch_long_axis_mm, "mm", card),
    ...note("short axis", impact.patch_short_axis_mm, "mm", card),
  ];
}

function depth(results) {
  const { main, others } = significant(results);
  const label = main ? `Depth of stress above ${threshold(main.threshold_pa)}` : "Depth of significant stress";
  const above = (stress) => note(`above ${threshold(stress.threshold_pa)}:`, stress.depth_mm, "mm", main.depth_mm);
  return { label, unit: "mm", quantity: main?.depth_mm, notes: main && ["von Mises stress, below the skin", ...ends(main), ...others.flatMap(above)] };
}

/** Where what is above a threshold goes on beyond the model. */
function ends({ reaches = [] }) {
  return reaches.map((end) => `reaches ${end}: at least so deep`);
}

function energyNotes(tissue) {
  const when = tissue.contact_ended ? "when contact had ended" : "at the end; contact has not ended";
  const card = tissue.energy_given_j;
  return [when, ...note("absorbed so far", tissue.absorbed_energy_j, "J", card), ...note("the projectile lost", tissue.projectile_loss_j, "J", card)];
}
