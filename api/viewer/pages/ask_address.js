// The address of a question and of its answer: whoever opens it has the same question, and reads the jobs that answer it.

import { setting } from "../format.js";
import { SPEED as SPEED_OF_OWN } from "../scene/own_ball.js";
import { PROJECTILES } from "../scene/projectiles.js";
import { NUMBERS, fatOf } from "../scene/question.js";
import { PERCENTILES, REGIONS } from "../scene/regions.js";

/** Bounds of the numbers that can be set. */
export const BOUNDS = { speed: [1, 400], threshold: [0.1, 10000], more: [1, 40], fat: [0.5, 60], diameter: [5, 150], mass: [0.5, 3000] };
export const THRESHOLD_KPA = 100;
/** In place of a projectile of the list, and of a percentile: the reader's own. */
export const OWN = "own";
/** A ball and a fat of the reader's own, before they are set [mm], [g], [mm]. */
const [DIAMETER_MM, MASS_G, FAT_MM] = [40, 100, 10];
const [MORE_FAT_MM, PERCENT] = [10, 50];

/**
 * What of a question stands in an address: {hit, ball, region, percent, ownFat, number, speeds, threshold, more, jobs}; the default for what does not.
 * `hit` is the id of a projectile, or `OWN` for the `ball` {diameter_mm, mass_g, hardness}, made of one of the `hardnesses`; `percent` may be `OWN`, too,
 * for `ownFat` [mm].
 */
export function questionIn(query, hardnesses) {
  const words = new URLSearchParams(query ?? "");
  const one = (list, name) => list.find(({ id }) => id === words.get(name)) ?? list[0];
  const number = (name, [low, high], usual) => {
    const value = Number(words.get(name) ?? NaN);
    return value >= low && value <= high ? value : usual;
  };
  const ball = { diameter_mm: number("mm", BOUNDS.diameter, DIAMETER_MM), mass_g: number("g", BOUNDS.mass, MASS_G), hardness: one(hardnesses, "of") };
  const isOwn = words.get("hit") === OWN;
  const known = one(PROJECTILES, "hit");
  const usual = isOwn ? SPEED_OF_OWN : known.speed;
  const percent = words.get("who") === OWN ? OWN : number("who", [0, 100], PERCENT);
  const speeds = ["from", "to"].map((name, i) => number(name, BOUNDS.speed, usual[i]));
  return {
    hit: isOwn ? OWN : known.id,
    ball,
    region: one(REGIONS, "where"),
    percent: [OWN, ...PERCENTILES.map(([of]) => of)].includes(percent) ? percent : PERCENT,
    ownFat: number("fat", BOUNDS.fat, FAT_MM),
    number: one(NUMBERS, "number"),
    speeds: speeds[0] < speeds[1] ? speeds : usual,
    threshold: number("kpa", BOUNDS.threshold, THRESHOLD_KPA),
    more: number("more", BOUNDS.more, MORE_FAT_MM),
    jobs: (words.get("jobs") ?? "").split(",").filter((id) => /^[\w-]+$/.test(id)),
  };
}

/** The address of a question; with the ids of its `jobs`, the second of which has `more` fat [mm], of its answer. */
export function addressOf({ projectile, region, percent, ownFat, number, speeds, threshold }, jobs = [], more = null) {
  const { id, diameter_mm, mass_g, made } = projectile;
  const own = { ...(id === OWN ? { mm: diameter_mm, g: mass_g, of: made } : {}), ...(percent === OWN ? { fat: setting(ownFat) } : {}) };
  const words = { hit: id, where: region.id, who: percent, ...own, from: speeds[0], to: speeds[1], kpa: threshold, number: number.id };
  if (jobs.length) words.jobs = jobs.join(",");
  if (jobs.length > 1) words.more = more;
  return `#/ask?${Object.entries(words).map(([name, value]) => `${name}=${value}`).join("&")}`;
}

/** The name of the job of a question: projectile, region, fat [mm], speeds [m/s] and threshold [kPa]; a ball of the reader's own has its diameter, mass and material. */
const NAME = /^what if: (.+) on (\w+), fat ([\d.]+) mm, ([\d.]+) to ([\d.]+) m\/s, ([\d.]+) kPa$/;
const BALL = /^(?:rigid )?ball ([\d.]+) mm ([\d.]+) g(?: (\w+))?$/;

/** The projectile of a name; null for none that can be asked about. */
function projectileNamed(words) {
  const [, diameter_mm, mass_g, made = "rigid"] = words.match(BALL) ?? [];
  if (mass_g) return { id: OWN, diameter_mm: Number(diameter_mm), mass_g: Number(mass_g), made };
  return PROJECTILES.find(({ id }) => id === words) ?? null;
}

/** The name of a job in words: what was asked, where it is a question of the page *Ask*, otherwise the name itself. */
export function titleOf(name) {
  const asked = askedIn(name);
  if (!asked) return name;
  const { projectile, region, ownFat, speeds, threshold } = asked;
  const { made, diameter_mm, mass_g } = projectile;
  const ball = projectile.name ?? `${made === "rigid" ? "Rigid ball" : "Ball"}, ${diameter_mm} mm, ${mass_g} g`;
  const limb = region.name.split(",")[0].toLowerCase();
  return `${ball}, on the ${limb} with ${setting(ownFat)} mm of fat, ${speeds.map(setting).join(" to ")} m/s, stress above ${setting(threshold)} kPa`;
}

/** What was asked by the name of its job, its number the first of those that can be; null for other jobs. */
export function askedIn(name) {
  const [, hit, where, fat, ...numbers] = name.match(NAME) ?? [];
  const region = REGIONS.find(({ id }) => id === where);
  const projectile = hit && projectileNamed(hit);
  if (!region || !projectile) return null;
  const [percent] = PERCENTILES.find(([one]) => (fatOf(region, one) * 1e3).toFixed(1) === fat) ?? [OWN];
  const [low, high, threshold] = numbers.map(Number);
  return { projectile, region, percent, ownFat: Number(fat), fat: Number(fat) * 1e-3, number: NUMBERS[0], speeds: [low, high], threshold };
}
