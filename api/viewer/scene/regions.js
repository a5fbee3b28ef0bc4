// Regions of the body that can be asked about: layers with the spread of their thickness over people, and the body that models them.

/** Standard normal values of the percentiles that are offered. */
const NORMAL = { 5: -1.6449, 25: -0.6745, 50: 0, 75: 0.6745, 95: 1.6449 };
export const PERCENTILES = [[5, "thin: only 5 % of people have less fat there"], [25, "rather thin (25 %)"], [50, "in the middle (50 %)"], [75, "rather obese (75 %)"], [95, "obese: only 5 % have more"]];

/**
 * A percentile of a thickness that is log-normal over people, from its mean, the half width of the 95 % confidence interval of that mean,
 * and the number of people: their standard deviation is half width · √n / 1.96.
 */
export function percentile({ mean, halfWidth, people }, percent) {
  const deviation = (halfWidth * Math.sqrt(people)) / 1.96;
  const variance = Math.log(1 + (deviation / mean) ** 2);
  return mean * Math.exp(Math.sqrt(variance) * NORMAL[percent] - variance / 2);
}

/** The ends of the percentiles of fat over all regions [m]: no limb says which region it is. */
export const fatRange = () => [Math.min(...REGIONS.map(({ fat }) => percentile(fat, 5))), Math.max(...REGIONS.map(({ fat }) => percentile(fat, 95)))];

const GIBNEY = "Thickness of skin and fat by ultrasound in 388 adults with diabetes: Gibney, Arce, Byron, Hirsch (2010), Curr. Med. Res. Opin. 26, 1519–1530 (means with confidence intervals, from the abstract). Percentiles: log-normal with that mean and spread. ";

/** {id, name, source, skin_m, fat: distribution [m], core: semi-axes of the muscle around the bone [m], bone [m]}. */
export const REGIONS = [
  {
    id: "thigh", name: "Thigh, front", skin_m: 0.0019, fat: { mean: 0.0104, halfWidth: 0.00055, people: 388 }, core: [0.065, 0.06], bone: 0.014,
    source: `${GIBNEY}Muscle and bone: an ellipse of 130 × 120 mm around a bone of 28 mm, an assumption.`,
  },
  {
    id: "arm", name: "Upper arm", skin_m: 0.0022, fat: { mean: 0.0108, halfWidth: 0.00055, people: 388 }, core: [0.038, 0.036], bone: 0.011,
    source: `${GIBNEY}Muscle and bone: an ellipse of 76 × 72 mm around a bone of 22 mm, an assumption.`,
  },
];

/** Largest depth of the tissue of a region below its skin [m], with this much fat: at the bone, where it is farthest from the skin. */
export function deepestOf({ skin_m: skin, core, bone }, fat) {
  return skin + fat + Math.max(...core) - bone;
}

/** Thickness of an element of fat [m], about. */
const ELEMENT = 0.004;

/**
 * The region as the tissue of a scene, with this much fat [m] on the same muscle: {body, top}, `top` the height of the skin [m]. `parts`
 * are the materials of muscle, fat and skin.
 */
export function limbOf({ id, skin_m: skin, core: [a, c], bone }, fat, parts) {
  const generator = {
    kind: "limb_segment", semi_axis_x_m: a + fat + skin, semi_axis_z_m: c + fat + skin, length_m: 0.2, bone_semi_axis_x_m: bone, bone_semi_axis_z_m: bone,
    fat_thickness_m: fat, skin_thickness_m: skin, elements_around: 24, elements_along: 14, muscle_elements: 5, fat_elements: Math.max(2, Math.round(fat / ELEMENT)),
    skin_elements: 1, grading_around: 10, grading_along: 8, grading_muscle: 4,
  };
  return { body: { name: id, role: "tissue", mesh: { generator }, parts, fixed: [{ set: "bone" }] }, top: generator.semi_axis_z_m };
}
