// The answer of a curve in words.

import { bracketed, exceeds, number, setting, within } from "../format.js";
import { crossingOf, isKnownThroughout, isResolvedIn, surelyFrom, widthOf } from "../plots/crossing.js";
import { isCut } from "../scene/possible.js";

/** Numbers that differ by less than this part are the same [-]. */
const SAME = 1e-6;

/** From which speed on, in words, a level is exceeded by more than the uncertainty of a curve; `start` is the lowest speed. */
function beyond(curve, to, start) {
  const where = isKnownThroughout(curve) ? "" : " where that is known";
  if (to == null) return `, though not beyond the uncertainty${where}`;
  return to <= start ? `, beyond the uncertainty${where}` : `, beyond the uncertainty from ${number(to, 3)} m/s on${where}`;
}

/** A computed point in words: both ends where the error leads beyond what is possible, and in place of a number that is not resolved. */
function pointWords({ value, error, lower, upper, least, speed }, unit) {
  const at = `at ${setting(speed)} m/s`;
  if (error == null) return `${least ? "at least " : ""}${bracketed(value)} ${unit} with unknown error ${at}`;
  if (least) return `at least ${within(value, error)} ${unit} ${at}`;
  const ends = `between ${within(lower, error)} and ${within(upper, error)} ${unit}`;
  if (!exceeds(value, error)) return `not resolved by these runs: ${ends}, ${at}`;
  return isCut([lower, upper], error) ? `${within(value, error)} ${unit}, ${ends}, ${at}` : `${within(value, error)} ± ${number(error, 2)} ${unit} ${at}`;
}

/** How large the number is at the ends of the range; that it is the same at all speeds, where it is. */
function sizeIn({ asked: { number: what }, points }) {
  const [first, last] = [points[0], points.at(-1)];
  const isSame = points.every(({ value, least }) => Math.abs(value - first.value) <= SAME * Math.abs(first.value) && Boolean(least) === Boolean(first.least));
  return isSame ? `${pointWords(first, what.unit)}, and the same at all speeds up to ${setting(last.speed)} m/s.` : `${pointWords(first, what.unit)}; ${pointWords(last, what.unit)}.`;
}

/**
 * What is known of the speed from which on the stress is in the layer: {kind, at, low, high, hasError} with `low` and `high` the ends of its uncertainty,
 * 0 and Infinity where that is open, and `at` null where no curve crosses. `kind` is "crosses"; "unresolved" where the uncertainty covers the whole range, or
 * is as large as the speed; "above" or "below" at all speeds; "between" the curve and the first lower bound above; "bounded" where only lower bounds are known; "many"
 * where it is no one speed. Without `hasError` errors that are not known may move the ends, which are open.
 */
export function crossingKnown(one) {
  const known = crossingSeen(one);
  return known.hasError ? known : { ...known, low: 0, high: Infinity };
}

/** The same as far as there is a band: of a curve that does not cross, from the errors that are known. */
function crossingSeen(one) {
  const seen = rangeSeen(one);
  const isOpen = seen.kind === "crosses" ? !seen.hasError : !one.curve.stretches.length;
  if (isOpen) return { ...seen, low: 0, high: Infinity, hasError: false };
  return isAnswer(seen, one) ? seen : { ...seen, kind: "unresolved" };
}

/** Whether the uncertainty of what is known excludes a part of the speeds. */
function isAnswer(known, { asked: { speeds }, curve }) {
  if (known.kind === "crosses") return isResolvedIn(known, speeds);
  if (known.kind === "above") return known.high < Infinity;
  return known.kind !== "below" || known.low > curve.range[0];
}

/** The same without regard to how large the errors are, and to whether those that are not known may move the ends. */
function rangeSeen({ curve, points }) {
  const { at, from, to, isAbove, falls, hasError } = crossingOf(curve, 0);
  const high = to ?? surelyFrom(points) ?? Infinity;
  if (at == null && isAbove) return { kind: "above", at, low: 0, high, hasError };
  if (curve.isLeast) return { kind: "bounded", at: null, low: 0, high: to ?? Infinity, hasError };
  if (falls || fallsIn(points)) return { kind: "many", at: null, low: 0, high: Infinity, hasError };
  const [first, last] = curve.range;
  if (at != null) return { kind: "crosses", at, low: from <= first ? 0 : from, high, hasError };
  const isNext = points.some(({ speed, value }) => speed > last && value > 0);
  return isNext ? { kind: "between", at, low: from ?? last, high, hasError } : { kind: "below", at, low: from ?? last, high: Infinity, hasError };
}

/** The ends of an uncertainty in words, to the decimal place of its `width` where that is known. */
export function endWords({ low, high }, [first, last], width = null) {
  const [isOpenBelow, isOpenAbove] = [low <= first, high === Infinity];
  const words = (speed) => (width ? within(speed, width) : number(speed, 3));
  if (isOpenBelow && isOpenAbove) return `anywhere from below ${setting(first)} to above ${setting(last)} m/s`;
  if (isOpenBelow) return `less than ${words(high)} m/s`;
  return isOpenAbove ? `more than ${words(low)} m/s` : `between ${words(low)} and ${words(high)} m/s`;
}

/** That a crossing is not resolved, in words: `low` and `surely` are the ends of its uncertainty, `low` null and `surely` null where they are open. */
function unresolvedWords({ low, surely, all, does, doubt }) {
  const what = "not resolved by these runs";
  if (low == null && surely == null) return `${what}: with the uncertainty ${does("may exceed")} or stay below that, ${all}.`;
  if (low == null) return `${what} below ${number(surely, 3)} m/s; from there on ${does("exceeds")}${doubt(surely)}.`;
  if (surely == null) return `${what} above ${number(low, 3)} m/s; up to there ${does("stays below")}.`;
  return `${what}: ${does("exceeds")} from a speed between ${number(low, 3)} and ${number(surely, 3)} m/s on.`;
}

/** From which speed on the stress is in the layer. */
function crossingIn(one) {
  const { asked: { number: { layer }, threshold }, curve, points } = one;
  const does = (verb) => `the ${layer} ${verb} ${setting(threshold)} kPa`;
  const ends = points.every(({ value }) => value > 0) ? [points[0].speed, points.at(-1).speed] : curve.range;
  const all = `at all computed speeds, ${ends.map(setting).join(" to ")} m/s`;
  const known = crossingSeen(one);
  const { kind, at, low, high, hasError } = known;
  const [first, last] = curve.range;
  const surely = Number.isFinite(high) ? high : null;
  const isSeen = curve.stretches.length > 0;
  const doubt = (start) => (isSeen ? beyond(curve, surely, start) : "");
  const start = isSeen ? curve.stretches[0][0] : ends[0];
  if (kind === "above" && isSeen && surely > start) return unresolvedWords({ low: null, surely, all, does, doubt });
  if (kind === "above") return `${does("exceeds")} ${all}${doubt(start)}. Ask about lower ones.`;
  if (kind === "bounded") return crossingOfLeast(curve, does);
  if (kind === "unresolved") return unresolvedWords({ low: low > first ? low : null, surely, all, does, doubt });
  if (kind === "many") return `no one speed: the depth does not rise steadily with the speed, so that it crosses the top of the ${layer} more than once or downwards.`;
  if (kind === "between") {
    const next = points.find(({ speed, value }) => speed > last && value > 0).speed;
    return `${does("exceeds")} from a speed between ${setting(last)} and ${setting(next)} m/s on${doubt(next)}.`;
  }
  if (kind === "below") return `${does("stays below")} ${all}${isSeen && low < last ? `; with the uncertainty it may exceed it from ${number(low, 3)} m/s on` : ""}.`;
  if (!hasError) return `${does("exceeds")} from about ${number(at, 2)} m/s on, with unknown error.`;
  const width = widthOf({ at, from: low || first, to: surely ?? last });
  return `${does("exceeds")} from ${within(at, width)} m/s on (${endWords(known, curve.range, width)} with the uncertainty).`;
}

/** The same of a curve through lower bounds: it says from which speed on at the latest. */
function crossingOfLeast(curve, does) {
  const { to, hasError } = crossingOf(curve, 0);
  const { to: latest } = crossingOf({ ...curve, lower: curve.value, stretches: [curve.range] }, 0);
  if (latest == null) return `${does("may exceed")}: only lower bounds are known, and they do not reach it.`;
  return `${does("exceeds")} from ${number(latest, 3)} m/s on at the latest${hasError ? beyond(curve, to, latest) : ""}.`;
}

/** Whether a lower bound above the level is followed by a value below it. */
function fallsIn(points) {
  const above = points.findIndex(({ value, least }) => least && value > 0);
  return above >= 0 && points.slice(above).some(({ value, least }) => !least && value <= 0);
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

/** At which speeds the numerical error is not known, and what the curve has of a band. */
function unknownIn({ points, curve }) {
  const speeds = points.filter(({ error }) => error == null).map(({ speed }) => setting(speed));
  if (!speeds.length) return "";
  const band = isKnownThroughout(curve) ? "" : `, so that the curve has no band${curve.stretches.length ? " there" : ""}`;
  return ` The numerical error is not known ${speeds.length === points.length ? "at any of the speeds" : `at ${speeds.join(", ")} m/s`}${band}.`;
}

/** The answer of a curve in a sentence, and what limits it. */
export function sentenceOn(one) {
  const { asked: { number: what }, curve, failures, isOpen, isStopped, points } = one;
  if (isOpen) return "computing …";
  const missing = failures.length ? ` At ${failures.map(({ speed }) => setting(speed)).join(", ")} m/s the computation gives no result (${failures[0].reason}).` : "";
  if (!curve) return `${isStopped ? "stopped before there was a curve" : "no answer"}.${missing}`;
  return `${what.layer ? crossingIn(one) : sizeIn(one)}${boundsIn(points)}${unknownIn(one)}${missing}`;
}
