// The answer of a curve in words.

import { bracketed, number, setting } from "../format.js";
import { crossingOf } from "../plots/answer_curve.js";

/** Numbers that differ by less than this part are the same [-]. */
const SAME = 1e-6;

/** From which speed on, in words, a level is exceeded by more than the uncertainty; `start` is the lowest speed. */
function beyond(to, start) {
  if (to == null) return ", though not beyond the uncertainty";
  return to <= start ? ", beyond the uncertainty" : `, beyond the uncertainty from ${number(to, 3)} m/s on`;
}

/** A computed point in words: its number in brackets when the error is as large, or not known; both ends where the error leads beyond what is possible. */
function pointWords({ value, error, lower, upper, least, speed }, unit) {
  const at = `at ${setting(speed)} m/s`;
  if (least) return `at least ${number(value)} ${unit} ${at}`;
  if (error == null) return `(${number(value)}) ${unit} ${at}`;
  const isCut = upper - lower < 2 * error * (1 - SAME);
  const uncertain = isCut ? ` ${unit}, between ${number(lower, 2)} and ${number(upper, 2)} ${unit},` : ` ± ${number(error, 2)} ${unit}`;
  return `${bracketed(value, error)}${uncertain} ${at}`;
}

/** How large the number is at the ends of the range; that it is the same at all speeds, where it is. */
function sizeIn({ asked: { number: what }, points }) {
  const [first, last] = [points[0], points.at(-1)];
  const isSame = points.every(({ value, least }) => Math.abs(value - first.value) <= SAME * Math.abs(first.value) && Boolean(least) === Boolean(first.least));
  return isSame ? `${pointWords(first, what.unit)}, and the same at all speeds up to ${setting(last.speed)} m/s.` : `${pointWords(first, what.unit)}, ${pointWords(last, what.unit)}.`;
}

/** From which speed on the stress is in the layer. */
function crossingIn({ asked: { number: { layer }, threshold }, curve, points }) {
  const does = (verb) => `the ${layer} ${verb} ${setting(threshold)} kPa`;
  const ends = points.every(({ value }) => value > 0) ? [points[0].speed, points.at(-1).speed] : curve.range;
  const all = `at all computed speeds, ${ends.map(setting).join(" to ")} m/s`;
  const { at, from, to, isAbove, falls } = crossingOf(curve, 0, curve.range);
  const surely = to ?? surelyFrom(points);
  if (at == null && isAbove) return `${does("exceeds")} ${all}${beyond(surely, ends[0])}. Ask about lower ones.`;
  if (curve.isLeast) return crossingOfLeast(curve, does);
  if (falls || fallsIn(points)) return `no one speed: the depth does not rise steadily with the speed, so that it crosses the top of the ${layer} more than once or downwards.`;
  const [low, high] = curve.range;
  const next = points.find(({ speed, value }) => speed > high && value > 0);
  if (at == null && next) return `${does("exceeds")} from a speed between ${setting(high)} and ${setting(next.speed)} m/s on${beyond(surely, next.speed)}.`;
  if (at == null) return `${does("stays below")} ${all}${from == null ? "" : `; with the uncertainty it may exceed it from ${number(from, 3)} m/s on`}.`;
  const least = from <= low ? `less than ${setting(low)}` : number(from, 3);
  const most = surely == null ? `more than ${setting(high)}` : number(surely, 3);
  return `${does("exceeds")} from ${number(at, 3)} m/s on (between ${least} and ${most} m/s with the uncertainty).`;
}

/** The same of a curve through lower bounds: it says from which speed on at the latest. */
function crossingOfLeast(curve, does) {
  const { to } = crossingOf(curve, 0, curve.range);
  const { to: latest } = crossingOf({ ...curve, lower: curve.value }, 0, curve.range);
  if (latest == null) return `${does("may exceed")}: only lower bounds are known, and they do not reach it.`;
  return `${does("exceeds")} from ${number(latest, 3)} m/s on at the latest${beyond(to, latest)}.`;
}

/** Whether a lower bound above the level is followed by a value below it. */
function fallsIn(points) {
  const above = points.findIndex(({ value, least }) => least && value > 0);
  return above >= 0 && points.slice(above).some(({ value, least }) => !least && value <= 0);
}

/** The speed from which on all points are above the level by more than their errors; null where the last is not. */
function surelyFrom(points) {
  return points[points.findLastIndex(({ lower }) => !(lower > 0)) + 1]?.speed ?? null;
}

/** At which speeds the numbers are lower bounds, and why. */
function boundsIn(points) {
  const reasons = [...new Set(points.map(({ least }) => least).filter(Boolean))];
  return reasons.map((reason) => {
    const speeds = points.filter(({ least }) => least === reason).map(({ speed }) => setting(speed));
    const where = speeds.length === points.length ? "At all speeds" : `At ${speeds.join(", ")} m/s`;
    return ` ${where} the number is a lower bound: ${reason}.`;
  }).join("");
}

/** The answer of a curve in a sentence, and what limits it. */
export function sentenceOn(one) {
  const { asked: { number: what }, curve, failures, isOpen, isStopped, points } = one;
  if (isOpen) return "computing …";
  const missing = failures.length ? ` At ${failures.map(({ speed }) => setting(speed)).join(", ")} m/s the computation gives no result (${failures[0].reason}).` : "";
  if (!curve) return `${isStopped ? "stopped before there was a curve" : "no answer"}.${missing}`;
  const unknown = points.some(({ error }) => error == null) ? " The numerical error is not known at all speeds." : "";
  return `${what.layer ? crossingIn(one) : sizeIn(one)}${boundsIn(points)}${unknown}${missing}`;
}
