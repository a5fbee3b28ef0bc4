// The line of the impact: where the projectile meets the surface, and straight in from there.

import { firstCrossing } from "../mesh/along_line.js";
import { surfaceOf } from "../mesh/cells.js";
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
  if (!state) return null;
  if (!lines.has(contacts)) lines.set(contacts, lineAtRest(tissue, contacts, state.positions, restAt(tissue, frame.time)));
  return lines.get(contacts);
}

/** Lines by the contacts that they were found from. */
const lines = new WeakMap();

/** The nodes of an undeformed body at a time [s], with its flight [m]. */
function restAt({ X, V }, time) {
  const rest = X.slice();
  for (let i = 0; i < rest.length; i++) rest[i] += V[i % 3] * Math.max(time, 0);
  return rest;
}

/** The line at the `rest` of a tissue whose nodes are at `positions` [m]. */
function lineAtRest(tissue, contacts, positions, rest) {
  const { points, normal, centre } = flatPatch(contacts);
  const { triangles } = surfaceOf(tissue);
  const touched = contacts.slave === tissue.name ? points.map(({ node }) => node) : nearestNodes(triangles, positions, contacts.position_m);
  const direction = inwards(triangles, rest, touched, normal);
  // Out beyond the touched nodes at rest, and in to the first crossing.
  const reach = LEAST_REACH + Math.max(...touched.map((node) => Math.hypot(...centre.map((c, k) => c - rest[3 * node + k]))));
  const origin = centre.map((c, k) => c - reach * direction[k]);
  const away = firstCrossing(triangles, rest, origin, direction);
  return { centre: away < Infinity ? origin.map((c, k) => c + away * direction[k]) : centre, direction };
}

/** Of the nodes of some triangles those nearest to places, x y z each. */
function nearestNodes(triangles, positions, places) {
  const nodes = new Uint32Array(new Set(triangles));
  return Array.from({ length: places.length / 3 }, (_, p) => {
    const [x, y, z] = places.subarray(3 * p, 3 * p + 3);
    let [best, least] = [nodes[0], Infinity];
    for (let i = 0; i < nodes.length; i++) {
      const at = 3 * nodes[i];
      const away = (positions[at] - x) ** 2 + (positions[at + 1] - y) ** 2 + (positions[at + 2] - z) ** 2;
      if (away < least) {
        best = nodes[i];
        least = away;
      }
    }
    return best;
  });
}

/** The mean inward normal of the facets around the touched nodes, by their areas, of those that face along the contacts' `normal`. */
function inwards(triangles, rest, touched, normal) {
  const isTouched = new Uint8Array(rest.length / 3);
  for (const node of touched) isTouched[node] = 1;
  const at = (node) => [rest[3 * node], rest[3 * node + 1], rest[3 * node + 2]];
  const areas = [];
  for (let t = 0; t < triangles.length; t += 3) {
    if (!isTouched[triangles[t]] && !isTouched[triangles[t + 1]] && !isTouched[triangles[t + 2]]) continue;
    const [a, b, c] = [at(triangles[t]), at(triangles[t + 1]), at(triangles[t + 2])];
    areas.push(cross(a.map((x, k) => b[k] - x), a.map((x, k) => c[k] - x)));
  }
  const facing = areas.filter((area) => Math.abs(dot(area, normal)) > FACING * Math.hypot(...area));
  const mean = [0, 1, 2].map((k) => (facing.length ? facing : areas).reduce((sum, area) => sum - area[k], 0));
  return mean.map((c) => c / Math.hypot(...mean));
}

/** The frame in which what flies is nearest to the line's `centre`, or to that of its approach: {time, position}; null where nothing flies. */
export function nearestApproach(recording, { centre } = approachLine(recording) ?? {}) {
  const name = flying(recording)?.name;
  if (!centre || !name) return null;
  const places = recording.frames.map(({ time, bodies }) => ({ time, state: bodies.get(name) })).filter(({ state }) => state)
    .map(({ time, state }) => ({ time, position: placeOf(state) }));
  const away = ({ position }) => Math.hypot(...position.map((c, k) => c - centre[k]));
  return places.reduce((best, one) => (!best || away(one) < away(best) ? one : best), null);
}

const placeOf = ({ pose, positions }) => pose?.position ?? middleOf(positions);

/** The first projectile of a scene that moves. */
function flying({ scene }) {
  return (scene?.bodies ?? []).find((body) => body.role === "projectile" && Math.hypot(...(body.velocity_m_per_s ?? [0])) > 0);
}

/** Before anything touches: from the projectile along its velocity to the first node of the tissue near that path; null without one. */
export function approachLine(recording) {
  const { tissue, frames } = recording;
  const projectile = flying(recording);
  const state = frames[0]?.bodies.get(projectile?.name);
  if (!tissue || !state) return null;
  const speed = Math.hypot(...projectile.velocity_m_per_s);
  const direction = projectile.velocity_m_per_s.map((v) => v / speed);
  const from = placeOf(state);
  const along = (i) => direction.reduce((sum, d, k) => sum + d * (tissue.X[3 * i + k] - from[k]), 0);
  const off = (i, s) => Math.hypot(...direction.map((d, k) => tissue.X[3 * i + k] - from[k] - s * d));
  const nodes = Array.from({ length: tissue.X.length / 3 }, (_, i) => ({ s: along(i) })).map(({ s }, i) => ({ s, off: off(i, s) }));
  const nearest = Math.min(...nodes.map((node) => node.off));
  const s = Math.min(...nodes.filter((node) => node.off < nearest + 0.003).map((node) => node.s));
  return Number.isFinite(s) ? { centre: from.map((c, k) => c + s * direction[k]), direction } : null;
}
