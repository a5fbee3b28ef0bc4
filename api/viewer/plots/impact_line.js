// The line of the impact: where the projectile meets the surface, and straight in from there.

import { surfaceOf, valuesAlong } from "../mesh/cells.js";
import { cross, dot, flatPatch } from "./flat_patch.js";
import { isOn, mainPair } from "./main_pair.js";

/** Facets around an edge that face elsewhere are not those that were struck: least cosine [-]. */
const FACING = 0.5;
/** The surface is looked for from at least so far outside [m]. */
const LEAST_REACH = 1e-3;

/** Mean of points, x y z each. */
function middleOf(points) {
  return [0, 1, 2].map((k) => points.reduce((sum, c, i) => (i % 3 === k ? sum + c : sum), 0) / (points.length / 3));
}

/**
 * Where the surface at rest is struck, and straight in from there: {centre, direction}. The line goes through the centre of the force
 * of the first recorded contacts of the main pair, along the mean normal of the undeformed facets that they touch. Null without contact.
 */
export function impactLine(recording) {
  const { tissue, frames } = recording;
  const isTouching = ({ pair, node }) => tissue && node?.length && isOn(tissue.name, pair);
  const found = frames.flatMap((frame) => (frame.contacts ?? []).filter(isTouching).map((contacts) => ({ frame, contacts })));
  const main = mainPair(recording);
  const { frame, contacts } = found.find(({ contacts: { pair } }) => pair === main) ?? found[0] ?? {};
  const state = frame?.bodies.get(tissue.name);
  return state ? lineAtRest(tissue, contacts, state.positions, tissue.X.map((x, i) => x + tissue.V[i % 3] * Math.max(frame.time, 0))) : null;
}

/** The line at the `rest` of a tissue whose nodes are at `positions` [m]. */
function lineAtRest(tissue, contacts, positions, rest) {
  const { points, normal, centre } = flatPatch(contacts);
  const { triangles } = surfaceOf(tissue);
  const surface = [...new Set(triangles)];
  const touched = points.map(({ node }, i) => (contacts.slave === tissue.name ? node : nearest(surface, positions, contacts.position_m.subarray(3 * i, 3 * i + 3))));
  const direction = inwards(triangles, rest, new Set(touched), normal);
  // Out beyond the touched nodes at rest, and in to the first crossing.
  const reach = LEAST_REACH + Math.max(...touched.map((node) => Math.hypot(...centre.map((c, k) => c - rest[3 * node + k]))));
  const origin = centre.map((c, k) => c - reach * direction[k]);
  const hit = valuesAlong({ cells: tissue.cells, positions: rest, values: rest, origin, direction }).find(({ s }) => s >= 0);
  return { centre: hit ? origin.map((c, k) => c + hit.s * direction[k]) : centre, direction };
}

/** Of some nodes the one nearest to a place. */
function nearest(nodes, positions, [x, y, z]) {
  let [best, least] = [nodes[0], Infinity];
  for (const node of nodes) {
    const away = (positions[3 * node] - x) ** 2 + (positions[3 * node + 1] - y) ** 2 + (positions[3 * node + 2] - z) ** 2;
    if (away < least) [best, least] = [node, away];
  }
  return best;
}

/** The mean inward normal of the facets around the touched nodes, by their areas, of those that face along the contacts' `normal`. */
function inwards(triangles, rest, touched, normal) {
  const at = (node) => [rest[3 * node], rest[3 * node + 1], rest[3 * node + 2]];
  const areas = Array.from({ length: triangles.length / 3 }, (_, t) => triangles.subarray(3 * t, 3 * t + 3))
    .filter((nodes) => nodes.some((node) => touched.has(node)))
    .map((nodes) => Array.from(nodes, at))
    .map(([a, b, c]) => cross(a.map((x, k) => b[k] - x), a.map((x, k) => c[k] - x)));
  const facing = areas.filter((area) => Math.abs(dot(area, normal)) > FACING * Math.hypot(...area));
  const mean = [0, 1, 2].map((k) => (facing.length ? facing : areas).reduce((sum, area) => sum - area[k], 0));
  return mean.map((c) => c / Math.hypot(...mean));
}

/** Before anything touches: from the projectile along its velocity to the first node of the tissue near that path; null without one. */
export function approachLine(recording) {
  const { tissue, scene, frames } = recording;
  const projectile = (scene?.bodies ?? []).find((body) => body.role === "projectile" && Math.hypot(...(body.velocity_m_per_s ?? [0])) > 0);
  const state = frames[0]?.bodies.get(projectile?.name);
  if (!tissue || !state) return null;
  const speed = Math.hypot(...projectile.velocity_m_per_s);
  const direction = projectile.velocity_m_per_s.map((v) => v / speed);
  const from = state.pose?.position ?? middleOf(state.positions);
  const along = (i) => direction.reduce((sum, d, k) => sum + d * (tissue.X[3 * i + k] - from[k]), 0);
  const off = (i, s) => Math.hypot(...direction.map((d, k) => tissue.X[3 * i + k] - from[k] - s * d));
  const nodes = Array.from({ length: tissue.X.length / 3 }, (_, i) => ({ s: along(i) })).map(({ s }, i) => ({ s, off: off(i, s) }));
  const nearest = Math.min(...nodes.map((node) => node.off));
  const s = Math.min(...nodes.filter((node) => node.off < nearest + 0.003).map((node) => node.s));
  return Number.isFinite(s) ? { centre: from.map((c, k) => c + s * direction[k]), direction } : null;
}
