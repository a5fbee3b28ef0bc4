// The address of a question and of its answer: whoever opens it has the same question, and reads the jobs that answer it.

import { NUMBERS } from "../scene/question.js";
import { PROJECTILES } from "../scene/projectiles.js";
import { PERCENTILES, REGIONS } from "../scene/regions.js";

/** Bounds of the numbers that can be set. */
export const BOUNDS = { speed: [1, 400], threshold: [0.1, 10000], more: [1, 40] };
export const THRESHOLD_KPA = 100;
const [MORE_FAT_MM, PERCENT] = [10, 50];

/** What of a question stands in an address: {projectile, region, percent, number, speeds, threshold, more, jobs}; the default for what does not. */
export function questionIn(query) {
  const words = new URLSearchParams(query ?? "");
  const one = (list, name) => list.find(({ id }) => id === words.get(name)) ?? list[0];
  const number = (name, [low, high], usual) => {
    const value = Number(words.get(name) ?? NaN);
    return value >= low && value <= high ? value : usual;
  };
  const projectile = one(PROJECTILES, "hit");
  const percent = number("who", [0, 100], PERCENT);
  const speeds = ["from", "to"].map((name, i) => number(name, BOUNDS.speed, projectile.speed[i]));
  return {
    projectile,
    region: one(REGIONS, "where"),
    percent: PERCENTILES.some(([known]) => known === percent) ? percent : PERCENT,
    number: one(NUMBERS, "number"),
    speeds: speeds[0] < speeds[1] ? speeds : projectile.speed,
    threshold: number("kpa", BOUNDS.threshold, THRESHOLD_KPA),
    more: number("more", BOUNDS.more, MORE_FAT_MM),
    jobs: (words.get("jobs") ?? "").split(",").filter((id) => /^[\w-]+$/.test(id)),
  };
}

/** The address of a question; with the ids of its `jobs`, the second of which has `more` fat [mm], of its answer. */
export function addressOf({ projectile, region, percent, number, speeds, threshold }, jobs = [], more = null) {
  const words = { hit: projectile.id, where: region.id, who: percent, from: speeds[0], to: speeds[1], kpa: threshold, number: number.id };
  if (jobs.length) words.jobs = jobs.join(",");
  if (jobs.length > 1) words.more = more;
  return `#/ask?${Object.entries(words).map(([name, value]) => `${name}=${value}`).join("&")}`;
}
