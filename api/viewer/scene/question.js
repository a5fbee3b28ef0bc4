// A question as people ask it, as a what-if question of the service: one number against speed, for one person.

import { setting } from "../format.js";
import { deepestOf, limbOf, percentile } from "./regions.js";

/** Cases over the range of speeds, its ends among them: four inner ones, from which the error of the curve through them is estimated. */
const CASES = 6;
/** Significant digits of the speeds between the ends of a range. */
const OF_SPEED = 4;
/**
 * Modulus of tissue under a projectile, not above those that computed durations of contact have [Pa]: 0.2 to 1.3 MPa over all projectiles
 * (15 ms at 5 m/s for the cricket ball, 3.1 ms at 120 m/s for the flash-ball of 44 mm).
 */
const MODULUS_PA = 2e5;
const FIELD_TIMES = 40;

/** What can be asked: {key on the wire, words, unit, factor, of(threshold in words)}. */
export const NUMBERS = [
  { id: "muscle", key: "stress_depth_mm", layer: "muscle", words: (t) => `At which speed ${t} kPa in the muscle?`, axis: (t) => `depth of stress above ${t} kPa, below the top of the muscle`, unit: "mm" },
  { id: "fat", key: "stress_depth_mm", layer: "fat", words: (t) => `At which speed ${t} kPa in the fat?`, axis: (t) => `depth of stress above ${t} kPa, below the top of the fat`, unit: "mm" },
  { id: "depth", key: "stress_depth_mm", words: (t) => `How deep does stress above ${t} kPa go?`, axis: (t) => `depth of stress above ${t} kPa, below the skin`, unit: "mm" },
  { id: "force", key: "peak_force_n", words: () => "How large is the force?", axis: () => "peak force", unit: "N" },
  { id: "energy", key: "energy_given_j", words: () => "How much energy goes into the tissue?", axis: () => "energy given to the tissue", unit: "J" },
];

/** Whether a number is a depth of stress above a threshold. */
export const isDepth = ({ key }) => key === "stress_depth_mm";

/** Thickness of the fat of a person [m], to a tenth of a millimetre. */
export function fatOf(region, percent) {
  return Math.round(percentile(region.fat, percent) * 1e4) / 1e4;
}

/** Depth of the top of a layer below the skin [mm]; 0 for what is measured from the skin. */
export function topOf({ layer }, region, fat) {
  if (layer === "fat") return region.skin_m * 1e3;
  return layer === "muscle" ? (region.skin_m + fat) * 1e3 : 0;
}

/** Borders of the layers under the impact, and where the model ends, {name, at}: depths measured as the number of a question is [mm]; none for what is no depth. */
export function bordersOf({ number, region, fat }) {
  if (!isDepth(number)) return [];
  const { skin_m: skin, core, bone } = region;
  const depths = [["skin", 0], ["top of the fat", skin], ["top of the muscle", skin + fat], ["bone under the impact", skin + fat + core[1] - bone], ["deepest place, beside the bone", deepestOf(region, fat)]];
  return depths.map(([name, depth]) => ({ name, at: Number((depth * 1e3 - topOf(number, region, fat)).toPrecision(9)) }));
}

/**
 * When all runs end [s]: when contact has ended, after half a period of the projectile on a spring of its radius times that modulus. It does not
 * depend on the range of speeds, so that two questions have one answer at one speed.
 */
export function endOf({ projectile: { mass_g, diameter_mm } }) {
  const stiffness = MODULUS_PA * diameter_mm * 0.5e-3;
  return Number((Math.PI * Math.sqrt((mass_g * 1e-3) / stiffness)).toPrecision(2));
}

/** The name of the scene of a question, by which a job is known to be of it; `askedIn` reads it. */
function nameOf({ projectile, region, fat, threshold, speeds }) {
  return `${projectile.label ?? projectile.id} on ${region.id}, fat ${(fat * 1e3).toFixed(1)} mm, ${speeds.map(setting).join(" to ")} m/s, ${setting(threshold)} kPa`;
}

/** The scene of the lowest speed; `tissue` the parts of muscle, fat and skin with their materials. */
export function sceneOf(asked, tissue) {
  const { projectile, region, fat, threshold, speeds } = asked;
  const { body, top } = limbOf(region, fat, tissue);
  const ball = projectile.body(top, speeds[0]);
  return {
    name: nameOf(asked),
    end_time_s: endOf(asked),
    bodies: [ball, body],
    contact: { friction: 0.3 },
    record: { field_interval_s: Number((endOf(asked) / FIELD_TIMES).toPrecision(3)), fields: ["von_mises"] },
    measures: { skin_set: "skin_outer", stress_thresholds_pa: [threshold * 1e3] },
  };
}

/** The what-if question: cases at equally spaced speeds, the first of them the base, each with an error of its own. */
export function questionOf(asked, tissue) {
  const [low, high] = asked.speeds;
  const between = Array.from({ length: CASES - 2 }, (_, i) => Number((low + ((i + 1) * (high - low)) / (CASES - 1)).toPrecision(OF_SPEED)));
  const speeds = [...between, high];
  const parameters = [{ name: "speed", change: { kind: "speed_m_per_s" }, low, high }];
  return { scene: sceneOf(asked, tissue), parameters, error_bars: "full", cases: speeds.map((speed) => ({ set: { speed } })) };
}
