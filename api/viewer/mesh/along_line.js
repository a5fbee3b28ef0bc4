// What a straight line meets: values of elements along it, the first of some triangles.

import { areAround, distancesAlong } from "./cells.js";

/** Values {s, value, element} along the ray origin + s · direction, s in metres, in order: where it crosses the tetrahedra's faces. */
export function valuesAlong({ cells, positions, values, origin, direction, eroded = null }) {
  const found = [];
  const point = (node) => [positions[3 * node], positions[3 * node + 1], positions[3 * node + 2]];
  const across = acrossLine(positions, origin, direction);
  for (let element = 0; element < cells.length; element++) {
    if (eroded?.[element] || !across.every((distances) => areAround(distances, cells, element))) continue;
    const nodes = cells.nodesOf(element);
    const corners = Array.from(nodes, point);
    for (const t of cells.kindOf(element).tetrahedra) {
      for (const [a, b, c] of [[t[0], t[1], t[2]], [t[0], t[1], t[3]], [t[0], t[2], t[3]], [t[1], t[2], t[3]]]) {
        const hit = crossing(corners[a], corners[b], corners[c], origin, direction);
        if (!hit) continue;
        const [u, v] = hit.barycentric;
        const value = (1 - u - v) * values[nodes[a]] + u * values[nodes[b]] + v * values[nodes[c]];
        found.push({ s: hit.s, value, element });
      }
    }
  }
  return found.sort((a, b) => a.s - b.s);
}

/** How far along the ray origin + s · direction, s ≥ 0, it first crosses triangles of nodes [lengths of `direction`]; Infinity where it does not. */
export function firstCrossing(triangles, positions, origin, direction) {
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  const point = (node) => [positions[3 * node], positions[3 * node + 1], positions[3 * node + 2]];
  let first = Infinity;
  for (let t = 0; t < triangles.length; t += 3) {
    // A triangle whose edges are shorter than the first node is away from the line is not crossed.
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const [x, y, z] = [positions[a] - ox, positions[a + 1] - oy, positions[a + 2] - oz];
    const away = (y * dz - z * dy) ** 2 + (z * dx - x * dz) ** 2 + (x * dy - y * dx) ** 2;
    if (away > Math.max(squareBetween(positions, a, b), squareBetween(positions, a, c)) * (dx * dx + dy * dy + dz * dz)) continue;
    const hit = crossing(point(triangles[t]), point(triangles[t + 1]), point(triangles[t + 2]), origin, direction);
    if (hit?.s >= 0 && hit.s < first) first = hit.s;
  }
  return first;
}

/** Square of the distance of two points that begin at these places of `positions` [m²]. */
function squareBetween(positions, a, b) {
  return (positions[a] - positions[b]) ** 2 + (positions[a + 1] - positions[b + 1]) ** 2 + (positions[a + 2] - positions[b + 2]) ** 2;
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const crossProduct = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Distances of points from a line in two directions across it, as two arrays. */
function acrossLine(positions, origin, direction) {
  const sizes = direction.map(Math.abs);
  const least = sizes.indexOf(Math.min(...sizes));
  const first = crossProduct(direction, [0, 1, 2].map((k) => Number(k === least)));
  return [first, crossProduct(direction, first)].map((axis) => distancesAlong(positions, axis, dot(axis, origin)));
}

/** Where a ray crosses a triangle (Möller and Trumbore 1997); edges count as inside. */
function crossing(a, b, c, origin, direction) {
  const [ab, ac] = [minus(b, a), minus(c, a)];
  const p = crossProduct(direction, ac);
  const determinant = dot(ab, p);
  if (Math.abs(determinant) < 1e-18) return null;
  const t = minus(origin, a);
  const u = dot(t, p) / determinant;
  const q = crossProduct(t, ab);
  const v = dot(direction, q) / determinant;
  const slack = 1e-6;
  if (u < -slack || v < -slack || u + v > 1 + slack) return null;
  return { s: dot(ac, q) / determinant, barycentric: [u, v] };
}
