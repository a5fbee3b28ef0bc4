// What more fat changes, in words: between the first and the second curve of an answer.

import { change, number, setting, within } from "../format.js";
import { widthOf } from "../plots/crossing.js";
import { isCut } from "../scene/possible.js";
import { crossingKnown, endWords } from "./asked_words.js";

/** What is known of a crossing, in words; null for nothing. */
function speedWords(known, range) {
  const { kind, at, low, high } = known;
  const isOpen = high === Infinity;
  if (kind === "unresolved") return endWords(known, range);
  if (at != null && low && !isOpen) {
    const width = widthOf({ at, from: low, to: high });
    return `${within(at, width)} ± ${number(width, 2)} m/s`;
  }
  if (low && !isOpen) return `between ${number(low, 3)} and ${number(high, 3)} m/s`;
  if (at != null) return `about ${number(at, 2)} m/s${low ? `, at least ${number(low, 3)}` : ""}${isOpen ? "" : `, at most ${number(high, 3)}`}`;
  if (low) return `more than ${number(low, 3)} m/s`;
  return isOpen ? null : `less than ${number(high, 3)} m/s`;
}

/** Of crossings: where they are, and whether they differ by more than their errors. */
function ofCrossings(first, second) {
  const { number: { layer }, threshold, more, speeds } = second.asked;
  const [before, after] = [first, second].map(crossingKnown);
  const [from, to] = [before, after].map((known) => speedWords(known, speeds));
  const fat = `With ${setting(more)} mm more fat`;
  if (!from || !to) return `What ${setting(more)} mm more fat changes is not known: one of the curves leaves the speed open.`;
  if (before.kind === after.kind && ["above", "below"].includes(after.kind)) {
    return `${fat} no difference is seen: the ${layer} ${after.kind === "above" ? "exceeds" : "stays below"} ${setting(threshold)} kPa with both, ${speeds.map(setting).join(" to ")} m/s.`;
  }
  const isApart = after.low >= before.high || before.low >= after.high;
  const isKnown = [before, after].every(({ at }) => at != null);
  const speed = `the speed at which the ${layer} exceeds ${setting(threshold)} kPa`;
  const move = `${fat} ${speed} moves from ${from} to ${to}`;
  if (![before, after].every(({ hasError }) => hasError)) return `${move}; the numerical errors are not known, so that this may be no difference.`;
  if (isApart) return `${move}: beyond the errors.`;
  if ([before, after].some(({ kind }) => kind === "unresolved")) return `What ${setting(more)} mm more fat changes is not resolved by these runs: ${speed} is ${from} without them, ${to} with them.`;
  return `${move}: ${isKnown ? "no difference beyond the errors" : "the errors leave open whether it does"}.`;
}

/** How a computed point differs from another at its speed: {speed, by, ends, scale, error}, the `ends` those that are possible of both. */
function differenceAt(before, after) {
  const ends = [after.lower - before.upper, after.upper - before.lower];
  return { speed: before.speed, by: after.value - before.value, ends, scale: Math.abs(before.value), error: before.error + after.error };
}

/** Whether both ends of a difference are to one side of none. */
const isClear = ({ ends: [low, high] }) => low > 0 || high < 0;

/** Of sizes: by how much they differ at equal speeds, where both are known. */
function ofSizes(first, second) {
  const { number: what, threshold, more } = second.asked;
  const isKnown = ({ least, error }) => !least && error != null;
  const pairs = first.points.filter(isKnown).flatMap((p) => {
    const q = second.points.find((one) => one.speed === p.speed && isKnown(one));
    return q ? [differenceAt(p, q)] : [];
  });
  const fat = `With ${setting(more)} mm more fat`;
  if (!pairs.length) return `What ${setting(more)} mm more fat changes is not known: at each speed one of the numbers is a lower bound, or has no known error.`;
  const words = ({ speed, by, ends, scale, error }) => {
    const [size, low, high] = [by, ...ends].map((value) => change(value, scale, error));
    const isEven = isClear({ ends }) && !isCut(ends, error);
    return `${isEven ? `${size} ± ${number(error, 2)}` : `between ${low} and ${high}`} ${what.unit} at ${setting(speed)} m/s`;
  };
  const sizes = [...new Set([pairs[0], pairs.at(-1)])].map(words).join(", ");
  const clear = pairs.filter(isClear);
  const which = clear.length === pairs.length ? "all" : `${clear.length} of the`;
  const left = pairs.length < first.points.length ? " that have both numbers" : "";
  if (!clear.length) return `${fat} no difference beyond the errors: ${sizes}.`;
  return `${fat} the ${what.axis(setting(threshold))} changes by ${sizes}; beyond the errors at ${which} ${pairs.length} speeds${left}.`;
}

/** The difference of the two curves of an answer in a sentence; empty until both are known. */
export function differenceOf([first, second]) {
  if (!second || ![first, second].every(({ isOpen, curve }) => !isOpen && curve)) return "";
  return second.asked.number.layer ? ofCrossings(first, second) : ofSizes(first, second);
}
