// The line of the impact: where the projectile meets the surface, and straight in from there.

import { flatPatch } from "./flat_patch.js";

/** Mean of points, x y z each. */
function middleOf(points) {
  return [0, 1, 2].map((k) => points.reduce((sum, c, i) => (i % 3 === k ? sum + c : sum), 0) / (points.length / 3));
}

/** Through the centre of the first contacts that were recorded, into the tissue: {centre, direction}; null without contact. */
export function impactLine(recording) {
  const { tissue } = recording;
  for (const frame of recording.frames) {
    const pairs = (frame.contacts ?? []).filter(({ pair }) => tissue && pair.includes(tissue.name)).map(flatPatch).filter(Boolean);
    if (!pairs.length || !tissue) continue;
    const [{ centre, normal }] = pairs;
    // Inwards is where the tissue is.
    const middle = middleOf(tissue.X);
    const side = normal.reduce((sum, n, k) => sum + n * (middle[k] - centre[k]), 0);
    return { centre, direction: normal.map((n) => (side < 0 ? -n : n)) };
  }
  return null;
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
