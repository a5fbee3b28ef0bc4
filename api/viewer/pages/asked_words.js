// The answer of a curve in words.

import { bracketed, number, setting } from "../format.js";
import { crossingOf } from "../plots/answer_curve.js";
import { isDepth } from "../scene/question.js";

/** Numbers that differ by less than this part are the same [-]. */
const SAME = 1e-6;

/** From which speed on, in words, a level is exceeded by more than the uncertainty; `start` is the lowest speed. */
function beyond(to, start) {
  if (to == null) return ", though not beyond the uncertainty";
  return to <= start ? ", beyond the uncertainty" : `, beyond the uncertainty from ${number(to, 3)} m/s on`;
}

/** A computed point in words: its number in brackets when the error is as large, or not known. */
function pointWords({ value, error, speed }, unit) {
  const shown = error == null ? `(${number(value)})` : `${bracketed(value, error)} ± ${number(error, 2)}`;
  return `${shown} ${unit} at ${setting(speed)} m/s`;
}

/** How large the number is at the ends of the range; that it is the same at all speeds, where it is. */
function sizeIn({ asked: { number: what }, points }) {
  const [first, last] = [points[0], points.at(-1)];
  const isSame = points.every(({ value }) => Math.abs(value - first.value) <= SAME * Math.abs(first.value));
  return isSame ? `${pointWords(first, what.unit)}, and the same at all speeds up to ${setting(last.speed)} m/s.` : `${pointWords(first, what.unit)}, ${pointWords(last, what.unit)}.`;
}

/** From which speed on the stress is in the layer. */
function crossingIn({ asked: { number: { layer }, threshold }, curve }) {
  const [low, high] = curve.range;
  const does = (verb) => `the ${layer} ${verb} ${setting(threshold)} kPa`;
  const all = `at all computed speeds, ${setting(low)} to ${setting(high)} m/s`;
  const { at, from, to, isAbove, falls } = crossingOf(curve, 0, curve.range);
  if (falls) return `no one speed: the depth does not rise steadily with the speed, so that it crosses the top of the ${layer} more than once or downwards.`;
  if (at == null && isAbove) return `${does("exceeds")} ${all}${beyond(to, low)}. Ask about lower ones.`;
  if (at == null) return `${does("stays below")} ${all}${from == null ? "" : `; with the uncertainty it may exceed it from ${number(from, 3)} m/s on`}.`;
  const least = from <= low ? `less than ${setting(low)}` : number(from, 3);
  const most = to == null ? `more than ${setting(high)}` : number(to, 3);
  return `${does("exceeds")} from ${number(at, 3)} m/s on (between ${least} and ${most} m/s with the uncertainty).`;
}

/** The answer of a curve in a sentence, and what limits it. */
export function sentenceOn(one) {
  const { asked: { number: what }, curve, failures, isOpen, isStopped, points, reaches } = one;
  if (isOpen) return "computing …";
  const missing = failures.length ? ` At ${failures.map(({ speed }) => setting(speed)).join(", ")} m/s the computation gives no result (${failures[0].reason}).` : "";
  if (!curve) return `${isStopped ? "stopped before there was a curve" : "no answer"}.${missing}`;
  const deeper = reaches.size && isDepth(what) ? ` At some of these speeds the stress reaches ${[...reaches].join(" and ")}: it would go deeper.` : "";
  const unknown = points.some(({ error }) => error == null) ? " The numerical error is not known at all speeds." : "";
  return `${what.layer ? crossingIn(one) : sizeIn(one)}${deeper}${unknown}${missing}`;
}
