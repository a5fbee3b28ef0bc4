// What a clinician would change about an impact, as parameters of a what-if question with their sliders' ranges.

import { fatRange } from "../scene/regions.js";

/** Spread of the stiffness of a tissue over people, standard deviation over mean: an assumption, and said to be. */
const STIFFNESS_SPREAD = 0.3;

/** How far an impact may be moved over the surface [m], to each side. */
const OVER_SURFACE = 0.02;

/** So much of the tissue between skin and bone can be fat [-]. */
const MOST_FAT = 0.8;

const norm = (v) => Math.hypot(...v);
/** An axis across a direction, for turning. */
const across = (v) => (Math.abs(v[1]) > 0.9 * norm(v) ? [1, 0, 0] : [0, 1, 0]);

/** The two axes of space that lie most across a direction. */
const axesAcross = (v) => [0, 1, 2].sort((a, b) => Math.abs(v[a]) - Math.abs(v[b])).slice(0, 2).sort();

/** The range of the thickness of a layer: half of it on both sides, of fat at least what people have, as far as the limb has room. */
function thicknesses({ semi_axis_x_m: a, semi_axis_z_m: c = a, bone_semi_axis_x_m: b = 0, bone_semi_axis_z_m: d = b, skin_thickness_m: skin = 0 }, layer, thickness) {
  const [low, high] = [0.5 * thickness, 1.5 * thickness];
  if (layer !== "fat") return { low, high };
  const [thin, thick] = fatRange();
  const most = MOST_FAT * (Math.min(a - b, c - d) - skin);
  return { low: Math.min(low, thin), high: Math.max(high, Math.min(thick, most)) };
}

/**
 * The parameters that fit a scene: {name, label, unit, factor, base, low, high, change}; base, low and high are in the unit of
 * the change, and times `factor` in `unit`. Where `mayEnd` is set, it is not known yet whether the scene extends to `low` and `high`.
 */
export function parametersOf(scene) {
  const bodies = scene.bodies ?? [];
  const projectile = bodies.find((body) => body.role === "projectile" && norm(body.velocity_m_per_s ?? [0]) > 0);
  const tissue = bodies.find((body) => body.role === "tissue");
  const limb = bodies.find((body) => body.mesh?.generator?.kind === "limb_segment");
  const plain = { unit: "", factor: 1 };
  const found = [];
  if (projectile) {
    const velocity = projectile.velocity_m_per_s;
    const speed = norm(velocity);
    found.push(
      { name: "speed", label: "Speed", unit: "m/s", factor: 1, base: speed, low: 0.5 * speed, high: 1.5 * speed, change: { kind: "speed_m_per_s", body: projectile.name } },
      { name: "angle", label: "Angle of the flight", unit: "°", factor: 1, base: 0, low: -45, high: 45, change: { kind: "angle_deg", body: projectile.name, about: across(velocity) } },
    );
  }
  if (limb && projectile) {
    const generator = limb.mesh.generator;
    const around = generator.impact_angle_deg ?? 0;
    found.push({ name: "place", label: "Place around the limb", unit: "°", factor: 1, base: around, low: around - 30, high: around + 30, change: { kind: "impact_around_deg", body: projectile.name, limb: limb.name } });
    for (const layer of ["fat", "skin"]) {
      const thickness = generator[`${layer}_thickness_m`];
      if (thickness > 0) found.push({ name: `${layer} thickness`, label: `Thickness of the ${layer}`, unit: "mm", factor: 1e3, base: thickness, ...thicknesses(generator, layer, thickness), change: { kind: "layer_thickness_m", layer, limb: limb.name } });
    }
  }
  if (projectile && tissue?.mesh && !limb) {
    for (const axis of axesAcross(projectile.velocity_m_per_s)) {
      const along = [0, 1, 2].map((i) => (i === axis ? 1 : 0));
      const letter = "xyz"[axis];
      found.push({ name: `over ${letter}`, label: `Place along ${letter} over the surface`, unit: "mm", factor: 1e3, base: 0, low: -OVER_SURFACE, high: OVER_SURFACE, mayEnd: true, change: { kind: "impact_offset_m", body: projectile.name, target: tissue.name, along } });
    }
  }
  const friction = scene.contact?.pairs?.[0]?.friction ?? scene.contact?.friction;
  if (friction > 0) found.push({ ...plain, name: "friction", label: "Friction", base: friction, low: 0, high: 2 * friction, change: { kind: "friction" } });
  for (const { part } of tissue?.parts ?? []) {
    found.push({
      name: `${part} stiffness`,
      label: `Stiffness of the ${part}, percentile of people (spread ${STIFFNESS_SPREAD} assumed)`,
      unit: "%", factor: 1, base: 50, low: 5, high: 95,
      change: { kind: "stiffness_percentile", body: tissue.name, part, coefficient_of_variation: STIFFNESS_SPREAD },
    });
  }
  return found;
}
