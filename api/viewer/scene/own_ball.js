// A ball of the reader's own: diameter, mass, and what it is made of.

import { number } from "../format.js";
import { RUBBER, SOFT_RUBBER, hollowBody, rigidBall, shoreA, solidBody } from "./projectiles.js";

/** Family of the library whose sets a ball can be made of. */
const FAMILY = "rubber/";
/** A ball is solid where its mass is that of one of its material within this part; a hollow one has an inner radius of these parts of the outer one. */
const [SAME_MASS, INNER] = [0.03, [0.3, 0.92]];
/** Range of speeds that is proposed [m/s]. */
export const SPEED = [10, 40];

/** What a ball can be made of: {id, name, density [kg/m³], part}, the rigid one first; `materials` are those of the library. */
export function hardnessesFrom(materials) {
  const sets = materials.filter(({ name }) => name.startsWith(FAMILY));
  return [
    { id: "rigid", name: "rigid: far harder than tissue" },
    { id: "soft", name: RUBBER, density: SOFT_RUBBER.density_kg_per_m3, part: SOFT_RUBBER },
    ...sets.map(({ name, tissue, shear_modulus_pa: shear, density_kg_per_m3: density }) => (
      { id: name.slice(FAMILY.length), name: `${tissue}, about ${Math.round(shoreA(shear))} Shore A`, density, part: { material: { library: name } } })),
  ];
}

/** Densities of bodies that are usual, as the service has them [kg/m³]. */
const USUAL_DENSITY = [100, 25000];

const gramsOf = (radius, density) => (4e3 / 3) * Math.PI * density * radius ** 3;
const grams = (mass) => `${Number(mass.toPrecision(2))} g`;

/** The body of a ball of a material: solid, or hollow so that it has its mass; a sentence instead where neither can be. */
function bodyOf(radius, mass_g, { density, part }) {
  const filled = mass_g / gramsOf(radius, density);
  if (Math.abs(filled - 1) <= SAME_MASS) return solidBody(radius, { ...part, density_kg_per_m3: Number((density * filled).toPrecision(6)) });
  const [thick, thin] = INNER.map((inner) => gramsOf(radius, density) * (1 - inner ** 3));
  const range = `A ball of ${2e3 * radius} mm of this material weighs from ${grams(thin)} (hollow) to ${grams(gramsOf(radius, density))} (solid)`;
  if (filled > 1 || mass_g < thin) return `${range}: change mass or diameter, or choose a rigid one.`;
  // Hardly hollow: the smallest hole that can be meshed, and a density that differs as little.
  const [inner, dense] = mass_g > thick ? [INNER[0], density * (mass_g / thick)] : [Math.cbrt(1 - filled), density];
  return hollowBody(radius, Number((inner * radius).toPrecision(6)), { ...part, density_kg_per_m3: Number(dense.toPrecision(6)) });
}

/** What is unusual about a ball, in a sentence: its mass for its size; null for nothing. */
export function unusualBall({ diameter_mm, mass_g }) {
  const density = mass_g / gramsOf(diameter_mm / 2e3, 1);
  const [least, most] = USUAL_DENSITY;
  if (density >= least && density <= most) return null;
  return `A ball of ${diameter_mm} mm that weighs ${mass_g} g has ${number(density, 2)} kg/m³, usually between ${least} and ${most} kg/m³ (water has 1000, steel 7850): are diameter and mass right?`;
}

/** The projectile of a choice {diameter_mm, mass_g, hardness}; a sentence instead where there is no such ball. */
export function ownBall({ diameter_mm, mass_g, hardness }) {
  const rigid = rigidBall(diameter_mm, mass_g);
  const common = { ...rigid, speed: SPEED, hardness: hardness.name, made: hardness.id, source: "Diameter, mass and material as you gave them." };
  if (!hardness.part) return { ...common, label: `rigid ball ${diameter_mm} mm ${mass_g} g` };
  const body = bodyOf(diameter_mm / 2e3, mass_g, hardness);
  if (typeof body === "string") return body;
  return { ...common, body, name: `Ball, ${diameter_mm} mm, ${mass_g} g`, label: `ball ${diameter_mm} mm ${mass_g} g ${hardness.id}` };
}
