// What the numbers of an impact can be at all: where their errors end.

import { deepestOf } from "./regions.js";

/** Ends that differ by less than this part of the error are those of the error [-]. */
const SAME = 1e-6;

/**
 * What a number on the wire can be at a speed, [least, most]: none below 0; where the question that is `asked` is known, no depth below the deepest place at
 * the bone, and no energy beyond that of the flying projectile. Depths are those below the skin [mm].
 */
export function possibleOf(key, asked = null) {
  if (asked && key === "stress_depth_mm") return () => [0, deepestOf(asked.region, asked.fat) * 1e3];
  if (asked && key === "energy_given_j") return (speed) => [0, 0.5e-3 * asked.projectile.mass_g * speed ** 2];
  return () => [0, Infinity];
}

/** Both ends of a value with its error, within what is possible; a value beyond that is its own end. */
export function endsWithin([least, most], value, error) {
  return [Math.max(value - error, Math.min(least, value)), Math.min(value + error, Math.max(most, value))];
}

/** Whether ends are nearer than the error: what is possible has cut them. */
export const isCut = ([lower, upper], error) => upper - lower < 2 * error * (1 - SAME);
