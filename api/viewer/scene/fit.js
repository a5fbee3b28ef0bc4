// A curve through computed points that rises and falls only where they do, and its error between them.

/** Index of the interval of `points` that holds a speed; the first and the last reach beyond the ends. */
function intervalOf(points, speed) {
  const after = points.findIndex((point, i) => i > 0 && speed <= point.speed);
  return (after < 0 ? points.length - 1 : after) - 1;
}

/** Slope at an end of the points: of the parabola through three of them, kept from overshooting. `h` and `d` are widths and slopes of chords. */
function slopeAtEnd([h0, h1], [d0, d1]) {
  const slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
  if (slope * d0 <= 0) return 0;
  return d0 * d1 <= 0 && Math.abs(slope) > 3 * Math.abs(d0) ? 3 * d0 : slope;
}

/**
 * Cubic Hermite interpolation of points {speed, value} in the order of speeds, monotone between neighbours: the condition of Fritsch, Carlson
 * (1980), SIAM J. Numer. Anal. 17, 238–246, with the slopes of Fritsch, Butland (1984), SIAM J. Sci. Stat. Comput. 5, 300–304. Two
 * points make a straight line.
 */
function interpolation(points) {
  const h = points.slice(1).map(({ speed }, i) => speed - points[i].speed);
  const d = points.slice(1).map(({ value }, i) => (value - points[i].value) / h[i]);
  const inner = d.slice(1).map((after, i) => {
    const [before, near, far] = [d[i], 2 * h[i + 1] + h[i], h[i + 1] + 2 * h[i]];
    return before * after <= 0 ? 0 : (near + far) / (near / before + far / after);
  });
  const ends = d.length < 2 ? [d[0], d[0]] : [slopeAtEnd(h, d), slopeAtEnd(h.toReversed(), d.toReversed())];
  const slopes = [ends[0], ...inner, ends[1]];
  return (speed) => {
    const i = intervalOf(points, speed);
    const t = (speed - points[i].speed) / h[i];
    const bend = slopes[i] - d[i] - t * (slopes[i] + slopes[i + 1] - 2 * d[i]);
    return points[i].value + h[i] * t * (d[i] + (1 - t) * bend);
  };
}

/**
 * The curve through points {speed, value} in the order of speeds, from the first to the last: {value(speed), error(speed), holdOut}; null with
 * fewer than three. `holdOut` is the root of the mean square, over the inner points, of what the curve through the others is off there;
 * `error` is that in the middle between two points, and 0 at them.
 */
export function fitted(points) {
  if (points.length < 3) return null;
  const off = points.slice(1, -1).map((left) => interpolation(points.filter((point) => point !== left))(left.speed) - left.value);
  const holdOut = Math.hypot(...off) / Math.sqrt(off.length);
  const error = (speed) => {
    const i = intervalOf(points, speed);
    const t = (speed - points[i].speed) / (points[i + 1].speed - points[i].speed);
    return Math.max(0, holdOut * 4 * t * (1 - t));
  };
  return { value: interpolation(points), error, holdOut };
}
