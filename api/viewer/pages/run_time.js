// How long a run takes as a whole, with the runs that its errors or its accuracy need.

import { number } from "../format.js";

/** So many times a run takes with its error bars, by the levels of meshes that they come from; meshes from files are split instead. */
const [TWO_LEVELS, THREE_LEVELS, SPLIT] = [4 / 3, 5 / 3, 20];
/** Runs on a split mesh are made if they take no longer [s]. */
const MOST_SPLIT_S = 60;

/** A time on the clock in words. */
export function duration(seconds) {
  if (seconds < 90) return `${number(seconds, 2)} s`;
  return seconds < 5400 ? `${number(seconds / 60, 2)} min` : `${number(seconds / 3600, 2)} h`;
}

/** The same with the runs of the error bars: [how long, what for]. */
function withErrors({ solver, bodies }, once) {
  const levels = solver?.error_bars;
  if (levels === "none") return [once, "without error bars"];
  const isFromFile = bodies?.some(({ mesh }) => mesh && !mesh.generator);
  if (isFromFile && SPLIT * once > MOST_SPLIT_S) return [once, "without error bars, which would take too long"];
  const times = isFromFile ? SPLIT : levels === "three_levels" ? THREE_LEVELS : TWO_LEVELS;
  return [once * times, "with its error bars"];
}

/** How long the whole run of a scene takes, by the time [s] that once through it is expected to take on one core. */
export function wholeRunWords(scene, once) {
  const { accuracy } = scene ?? {};
  const first = `once through ${accuracy ? "its first mesh" : "it"} about ${duration(once)} on one core`;
  if (!accuracy) {
    const [whole, what] = withErrors(scene ?? {}, once);
    return `the whole run takes about ${duration(whole)} ${what} (${first})`;
  }
  const { relative = 0.1, time_budget_s: budget = 60 } = accuracy;
  const until = `meshes are refined until errors are below ${number(100 * relative, 2)} %`;
  if (once > budget) return `the whole run takes at least about ${duration(once)}, more than the ${duration(budget)} that it may: its first mesh is its last`;
  return `the whole run takes up to about ${duration(budget)}: ${until}, or that time is used (${first})`;
}
