// A curve of second degree through computed points, and its error at a point that it was not fitted to.

/** Coefficients of Σ cₖ xᵏ by least squares, of the second degree or as many as there are points for; x is scaled to −1 … 1. */
function leastSquares(points) {
  const size = Math.min(3, points.length);
  const rows = Array.from({ length: size }, (_, i) => [
    ...Array.from({ length: size }, (_, j) => points.reduce((sum, { x }) => sum + x ** (i + j), 0)),
    points.reduce((sum, { x, y }) => sum + y * x ** i, 0),
  ]);
  for (let k = 0; k < size; k++) {
    const pivot = rows.slice(k).reduce((best, row, i) => (Math.abs(row[k]) > Math.abs(rows[best][k]) ? k + i : best), k);
    [rows[k], rows[pivot]] = [rows[pivot], rows[k]];
    for (let i = 0; i < size; i++) {
      if (i === k) continue;
      const factor = rows[i][k] / rows[k][k];
      rows[i] = rows[i].map((value, j) => value - factor * rows[k][j]);
    }
  }
  return rows.map((row, k) => row[size] / row[k]);
}

const at = (coefficients, x) => coefficients.reduce((sum, c, k) => sum + c * x ** k, 0);

/**
 * The curve through points {speed, value} over a range of speeds: {value(speed), holdOut}, the root of the mean square of what it is off on
 * each point when that is omitted; null with fewer than four points.
 */
export function fitted(points, [low, high]) {
  if (points.length < 4) return null;
  const scaled = points.map(({ speed, value }) => ({ x: (2 * speed - low - high) / (high - low), y: value }));
  const whole = leastSquares(scaled);
  const off = scaled.map(({ x, y }, i) => y - at(leastSquares(scaled.filter((_, j) => j !== i)), x));
  return {
    value: (speed) => at(whole, (2 * speed - low - high) / (high - low)),
    holdOut: Math.sqrt(off.reduce((sum, d) => sum + d * d, 0) / off.length),
  };
}
