// Where a curve with its band crosses a level, and whether errors that are known show where.

const STEPS = 120;

/** A function of speed at equal steps over a range, both ends among them: [speed, value]. */
export function sampled(f, [low, high], steps = STEPS) {
  return Array.from({ length: steps + 1 }, (_, i) => (i === steps ? high : low + (i * (high - low)) / steps)).map((speed) => [speed, f(speed)]);
}

/** The speed between two neighbouring samples of a function at which it is at a level, linear between them. */
function between([v0, f0], [v1, f1], level) {
  return v0 + ((level - f0) / (f1 - f0)) * (v1 - v0);
}

/** The first speed at which samples, in `runs` without gaps, are above a level: the start of a run that is so there; null if they never are. */
function firstAbove(runs, level) {
  for (const samples of runs) {
    const i = samples.findIndex(([, value]) => value > level);
    if (i >= 0) return i === 0 ? samples[0][0] : between(samples[i - 1], samples[i], level);
  }
  return null;
}

/** The speed from which on samples, in `runs` without gaps, stay above a level up to their end: the start of a run that always is; null if they are not above at the end. */
function lastAbove(runs, level) {
  let since = null;
  for (const samples of runs) {
    const i = samples.findLastIndex(([, value]) => !(value > level));
    if (i < 0) since ??= samples[0][0];
    else since = i === samples.length - 1 ? null : between(samples[i], samples[i + 1], level);
  }
  return since;
}

/** Whether the errors of a curve are known over all of its range. */
export const isKnownThroughout = ({ stretches, range }) => stretches.length === 1 && stretches[0].every((end, i) => end === range[i]);

/** Whether the errors of a curve are known at a speed. */
export const isKnownAt = ({ stretches }, speed) => stretches.some(([first, last]) => first <= speed && speed <= last);

/**
 * Whether known errors show where a curve crosses: it does so within a stretch where they are known, and its band leaves the level to both sides within that
 * stretch, or is cut there by the end of the curve. Of a curve that does not cross: whether they are known throughout.
 */
function isDecided({ stretches, range }, { at, from, to }) {
  if (at == null) return isKnownThroughout({ stretches, range });
  const [first, last] = stretches.find(([low, high]) => low <= at && at <= high) ?? [];
  if (first == null || from == null || from > last) return false;
  const startsWithin = from > first || (from === first && first === range[0]);
  return startsWithin && (to == null ? last === range[1] : to <= last);
}

/**
 * Where a curve {value(speed), lower(speed), upper(speed), range, stretches} crosses a level: {at, from, to, isAbove, falls, hasError}. `stretches` are
 * the speeds [first, last] between which its errors are known, in their order. `at` is where it rises through the level for the first time, null
 * where it does not. `from` is the first speed at which the upper end of its band is above, `to` the speed from which on the lower end stays above, as far as
 * there is a band. `isAbove` says whether all of it is above, and `falls` whether it falls through the level anywhere: then no one speed is an
 * answer. `hasError` says whether `from` and `to` are the ends of the crossing: without it, errors that are not known may move them.
 */
export function crossingOf(curve, level) {
  const values = sampled(curve.value, curve.range);
  const falls = values.some(([, value], i) => i > 0 && value <= level && values[i - 1][1] > level);
  const rises = values.findIndex(([, value], i) => i > 0 && value > level && values[i - 1][1] <= level);
  const known = (f) => curve.stretches.map((stretch) => sampled(f, stretch));
  const found = {
    at: rises < 0 ? null : between(values[rises - 1], values[rises], level),
    from: firstAbove(known(curve.upper), level),
    to: lastAbove(known(curve.lower), level),
    isAbove: values.every(([, value]) => value > level),
    falls,
  };
  return { ...found, hasError: isDecided(curve, found) };
}

/** The crossing that is marked in the picture of a curve: null where there is no level, no curve, or no one speed. */
export function markedCrossing(curve, level) {
  if (level == null || !curve) return null;
  const found = crossingOf(curve, level);
  return found.at == null || found.falls ? null : found;
}

/** The speed from which on all points are above 0 by more than their errors; null where the last is not, or its error is not known. */
export function surelyFrom(points) {
  return points[points.findLastIndex(({ lower, error }) => !(error != null && lower > 0)) + 1]?.speed ?? null;
}

/** Half the width of a crossing {at, from, to} with its uncertainty, at the wider side; 0 where that is open. */
export const widthOf = ({ at, from, to }) => Math.max(at - (from ?? at), (to ?? at) - at);

/**
 * Whether a crossing {at, low, high} is an answer over a range of speeds, `low` and `high` the ends of its uncertainty (0 and Infinity where they are
 * open): the uncertainty is less than the speed itself, and excludes a part of the range.
 */
export function isResolvedIn({ at, low, high }, [first, last]) {
  const [from, to] = [Math.max(low, first), Math.min(high, last)];
  return Math.max(at - from, to - at) < at && to - from < (1 - 1e-9) * (last - first);
}
