// What a summary says first: the hardest impact and the four numbers.

import { number, setting, timeUnit } from "../format.js";

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

/** The instant of the largest force by the summary of a run [s]; null where it says none. */
export function worstOf(summary) {
  const time = summary && mainImpact(resultsOf(summary))?.peak_force_time_s?.value;
  return time > 0 ? time : null;
}

/** Whether contact has ended: with all that strikes the tissue, else that of the main impact. */
export function contactEnded(results) {
  return results.tissue?.contact_ended ?? mainImpact(results)?.contact_ended ?? true;
}

/** Whether nothing touched in a run: then none of its numbers is of an impact. */
export function isMiss(summary) {
  return resultsOf(summary).nothing_touched === true;
}

/** A threshold of stress. */
export function threshold(pascal) {
  return `${setting(pascal / 1e3)} kPa`;
}

/** The stress whose depth stands for all: the one that the summary names, else that of the first threshold of the scene. */
function significant({ headline, tissue }) {
  return { main: (tissue?.significant_stress ?? [])[headline?.significant_stress ?? 0] };
}

/** The thresholds of stress [Pa] of a summary, ascending. */
export function significantThresholds(summary) {
  return (resultsOf(summary).tissue?.significant_stress ?? []).map((stress) => stress.threshold_pa);
}

/** The threshold [Pa] that the depth of stress is above; null where there is none. */
export function significantThreshold(summary) {
  return significant(resultsOf(summary)).main?.threshold_pa ?? null;
}

/**
 * The four numbers: {label, unit, quantity, note}, `isGrowing` where it is a lower bound since it may grow after the run, not at an end of the tissue, `limit` what its interval ends at, `isOfTheEnd` where it goes on after contact,
 * `average` [s] or a filter's name where it is a mean over time. The quantity is absent where the scene has no contact or no tissue, or the
 * run did not get there.
 */
export function headline(summary) {
  const results = resultsOf(summary);
  const impact = mainImpact(results);
  const { tissue } = results;
  return [
    { label: "Peak force", unit: "N", quantity: impact?.peak_force_n, isGrowing: isLeast(impact?.peak_force_n), average: impact?.force_window_s ?? impact?.force_filter, note: impact && forceNote(impact, results, summary) },
    { label: "Largest contact patch", unit: "mm²", quantity: impact?.largest_patch_area_mm2, isGrowing: isLeast(impact?.largest_patch_area_mm2), note: isLeast(impact?.largest_patch_area_mm2) && GREW },
    depth(results),
    { label: "Energy given to the tissue", unit: "J", quantity: tissue?.energy_given_j, isGrowing: isLeast(tissue?.energy_given_j), isOfTheEnd: true, limit: "all that the impact supplies", note: tissue && energyNote(results, impact) },
  ];
}

/** When the force was largest, and over what it is a mean (the steps are of the computation, not of the impact); of several on the tissue, which. */
function forceNote(impact, { impacts }, { end_time_s: end }) {
  const { pair, force_average: average, peak_force_time_s: time } = impact;
  const { factor, name } = timeUnit(end);
  const when = time && time.value > 0 ? `${number(time.value * factor, 3)} ${name} after the start` : null;
  const isOneOfSeveral = impacts.filter((impact) => impact.on_tissue).length > 1;
  return [isOneOfSeveral && pair, average?.replace(/, (\d+ steps|1\/\d+ of the contact)$/, "").replace(/\.0+(?= )/, ""), when, isLeast(impact.peak_force_n) && GREW].filter(Boolean).join(", ");
}

/** Whether a number is a lower bound. */
export const isLeast = (quantity) => quantity?.is_lower_bound ?? false;

/** What is said of a number that may grow after the run. */
const GREW = "or more: it still grew at the end";

function depth(results) {
  const { main } = significant(results);
  const isGrowing = isLeast(main?.depth_mm) && !main.depth_reaches?.length;
  const label = main ? `Depth of stress above ${threshold(main.threshold_pa)}` : "Depth of significant stress";
  const ends = (main?.depth_reaches ?? []).map((end) => end.replace(/^the held nodes “(.*)”$/, "the $1"));
  const why = [ends.length && `it reaches ${ends.join(" and ")}`, isGrowing && "it still grew at the end"].filter(Boolean);
  const least = why.length ? `, or more: ${why.join(", and ")}` : "";
  return { label, unit: "mm", quantity: main?.depth_mm, isGrowing, isOfTheEnd: true, limit: "where the tissue ends", note: main && `below the nearest surface${least}` };
}

function energyNote(results, impact) {
  if (!impact?.contact_span_s) return "at the end";
  if (isLeast(results.tissue.energy_given_j)) return "at the end, and more later: it still grew; some may return to the projectile";
  return contactEnded(results) ? "when contact had ended" : "at the end; contact has not ended";
}
