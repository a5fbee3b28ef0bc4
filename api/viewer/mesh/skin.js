// Depth below the surface at rest: the distance to what goes on smoothly around the impact.

import { surfaceOf } from "./cells.js";

/** Facets that meet at more than this belong to different surfaces: cosine [-]. */
const SMOOTH = Math.cos((40 * Math.PI) / 180);

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

export class Skin {
  /** Corners of its facets, three each [m]. */
  #corners;

  /** The skin of a body: the surface that goes on smoothly from the facet nearest to `place` [m], at rest. */
  constructor(body, place) {
    const { X } = body;
    const { triangles } = surfaceOf(body);
    const point = (node) => [X[3 * node], X[3 * node + 1], X[3 * node + 2]];
    const facets = Array.from({ length: triangles.length / 3 }, (_, t) => [0, 1, 2].map((i) => point(triangles[3 * t + i])));
    const normals = facets.map(([a, b, c]) => cross(minus(b, a), minus(c, a))).map((n) => n.map((x) => x / (Math.hypot(...n) || 1)));
    const byEdge = new Map();
    const count = X.length / 3;
    const edges = (t) => [0, 1, 2].map((i) => [triangles[3 * t + i], triangles[3 * t + ((i + 1) % 3)]]).map(([a, b]) => Math.min(a, b) * count + Math.max(a, b));
    facets.forEach((_, t) => edges(t).forEach((edge) => byEdge.set(edge, [...(byEdge.get(edge) ?? []), t])));
    const nearest = facets.map((facet) => distanceTo(facet, place)).reduce((best, d, t, all) => (d < all[best] ? t : best), 0);
    const [found, open] = [new Set([nearest]), [nearest]];
    while (open.length) {
      const t = open.pop();
      for (const next of edges(t).flatMap((edge) => byEdge.get(edge))) {
        if (found.has(next) || dot(normals[t], normals[next]) < SMOOTH) continue;
        found.add(next);
        open.push(next);
      }
    }
    this.#corners = [...found].map((t) => facets[t]);
  }

  /** Depth of a place at rest [m]. */
  depthOf(place) {
    return this.#corners.reduce((least, facet) => Math.min(least, distanceTo(facet, place)), Infinity);
  }
}

/** Distance of a point from a triangle (Ericson, Real-Time Collision Detection, 2005, 5.1.5). */
function distanceTo([a, b, c], p) {
  const [ab, ac, ap] = [minus(b, a), minus(c, a), minus(p, a)];
  const along = (from, direction, s) => Math.hypot(...minus(p, from.map((x, k) => x + s * direction[k])));
  const [d1, d2] = [dot(ab, ap), dot(ac, ap)];
  if (d1 <= 0 && d2 <= 0) return Math.hypot(...ap);
  const bp = minus(p, b);
  const [d3, d4] = [dot(ab, bp), dot(ac, bp)];
  if (d3 >= 0 && d4 <= d3) return Math.hypot(...bp);
  const vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return along(a, ab, d1 / (d1 - d3));
  const cp = minus(p, c);
  const [d5, d6] = [dot(ab, cp), dot(ac, cp)];
  if (d6 >= 0 && d5 <= d6) return Math.hypot(...cp);
  const vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return along(a, ac, d2 / (d2 - d6));
  const va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return along(b, minus(c, b), (d4 - d3) / (d4 - d3 + d5 - d6));
  const normal = cross(ab, ac);
  return Math.abs(dot(ap, normal)) / (Math.hypot(...normal) || 1);
}
