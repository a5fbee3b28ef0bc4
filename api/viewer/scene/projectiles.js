// Projectiles that can be asked about: mass, diameter, hardness, where the values are from, and the body that models them.

/** Gap between projectile and skin at the start [m]. */
const GAP = 20e-6;

/** Hardness of rubber [Shore A] from its shear modulus at rest [Pa], after Gent (1958), Rubber Chem. Technol. 31, 896; ν = ½. */
export function shoreA(shear_pa) {
  const youngs = 3e-6 * shear_pa;
  return (254 * 0.137505 * youngs - 0.0981 * 56) / (0.0981 * 7.62336 + 0.137505 * 2.54 * youngs);
}

const rubber = { law: "mooney_rivlin", c10_pa: 5e5, c01_pa: 1e5, bulk_modulus_pa: 5e7, volumetric: "quadratic_ln" };

/** A body of these members at rest above the place `top` [m], with a speed straight down [m/s]. */
function meshed(generator, part, radius) {
  return (top, speed) => ({
    name: "projectile", role: "projectile", mesh: { generator }, placement: { translation_m: [0, 0, top + radius + GAP] },
    parts: [{ part: "ball", ...part }], velocity_m_per_s: [0, 0, -speed],
  });
}

function rigid(radius, mass) {
  return (top, speed) => ({
    name: "projectile", role: "projectile", velocity_m_per_s: [0, 0, -speed],
    rigid: { shape: { kind: "ball", radius_m: radius }, center_m: [0, 0, top + radius + GAP], mass_kg: mass },
  });
}

/** A rigid ball of any diameter [mm] and mass [g]. */
export function rigidBall(diameter_mm, mass_g) {
  return { id: "own", name: `Rigid ball, ${diameter_mm} mm, ${mass_g} g`, mass_g, diameter_mm, body: rigid(diameter_mm / 2e3, mass_g / 1e3) };
}

/** A soft rubber as the part of a body; its constants are an assumption. */
export const SOFT_RUBBER = { density_kg_per_m3: 1000, shear_viscosity_pa_s: 5, material: rubber };

/** A hollow ball of a material, by its radii [m], as body(top, speed). */
export const hollowBody = (outer, inner, part) => meshed({ kind: "hollow_ball", outer_radius_m: outer, inner_radius_m: inner, elements_around: 8, elements_through: 2 }, part, outer);
/** A solid ball of a material, by its radius [m]. */
export const solidBody = (radius, part) => meshed({ kind: "solid_ball", radius_m: radius, elements_around: 4, elements_through: 3 }, part, radius);

const hollow = (outer, inner) => hollowBody(outer, inner, SOFT_RUBBER);
export const RUBBER = `soft rubber, about ${Math.round(shoreA(2 * (rubber.c10_pa + rubber.c01_pa)))} Shore A`;

/** {id, name, mass_g, diameter_mm, hardness, source, speed: [low, high] m/s, body(top, speed)}; one of the reader's own also has `label` and `made`. */
export const PROJECTILES = [
  {
    id: "flashball_44", name: "Flash-ball, 44 mm", mass_g: 28, diameter_mm: 44, hardness: RUBBER, speed: [60, 120], body: hollow(0.022, 0.01567),
    source: "Diameter and mass as stated for the weapon; hollow, so that the mass fits rubber of 1000 kg/m³. The constants of the rubber are an assumption.",
  },
  {
    id: "ball_30", name: "Hollow rubber ball, 30 mm", mass_g: 6.8, diameter_mm: 30, hardness: RUBBER, speed: [50, 120], body: hollow(0.015, 0.012),
    source: "Radius and speed of Chen, Joli, Cros, Feng (2010), World Congress of Biomechanics; the constants of the rubber are an assumption.",
  },
  {
    id: "steel_40", name: "Steel ball, 40 mm", mass_g: 263, diameter_mm: 40, hardness: "steel: rigid here", speed: [5, 20], body: rigid(0.02, 0.263),
    source: "Solid steel of 7850 kg/m³.",
  },
  {
    id: "cricket", name: "Cricket ball, 72 mm", mass_g: 160, diameter_mm: 72, hardness: "far harder than tissue: rigid here", speed: [5, 20], body: rigid(0.036, 0.16),
    source: "Laws of Cricket, law 4: circumference 224 to 229 mm, 156 to 163 g.",
  },
];
