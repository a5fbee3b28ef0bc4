// Words of a scene document that stand for one of several things, in plain words: those that can be exchanged for each other, and those that others depend on.

/** Members whose word can be exchanged for another: [word, plain words]. Others of that name in a document are no words of these lists. */
const CHOICES = {
  role: [["projectile", "projectile"], ["tissue", "target (tissue)"], ["other", "something else"]],
  error_bars: [["automatic", "whatever suits the scene"], ["two_levels", "one coarser mesh"], ["three_levels", "two coarser meshes"], ["none", "nothing: no errors"]],
  volumetric: [["quadratic", "quadratic: K/2 (J − 1)²"], ["quadratic_ln", "with a logarithm: K/4 (J² − 1 − 2 ln J)"], ["ln_squared", "logarithmic: K/2 (ln J)²"]],
  moduli: [["long_term", "after a long time"], ["instantaneous", "at once"]],
  matrix: [["isochoric", "without change of volume"], ["coupled", "with change of volume"]],
  self_contact: [["auto", "of all bodies that touch something"], ["none", "none"]],
  discretisation: [["two_pass", "nodes of both on faces of the other"], ["node_to_surface", "nodes of one on faces of the other"], ["mortar", "surface to surface (mortar)"]],
  formulation: [
    ["mean_dilatation", "mean change of volume"], ["mean_dilatation_single", "mean change of volume, in single precision"],
    ["full", "fully integrated"], ["reduced", "one point, stabilised"],
  ],
  force_filter: [["cfc_60", "CFC 60"], ["cfc_180", "CFC 180"], ["cfc_600", "CFC 600"], ["cfc_1000", "CFC 1000"]],
  region: [["head", "head"], ["thorax", "chest"], ["abdomen", "belly"], ["limb", "arm or leg"]],
  fields: [
    ["von_mises", "stress (von Mises)"], ["pressure", "pressure"], ["principal_strain", "strain (largest principal)"], ["displacement", "displacement"],
    ["velocity", "velocity"], ["element_cauchy_stress", "whole stress of each element"],
  ],
  of: [
    ["peak_force", "peak force"], ["impulse", "impulse"], ["contact_patch", "largest contact patch"], ["stress_depth", "depth of stress"],
    ["energy_given", "energy given to the tissue"], ["deflection", "deflection of the surface"],
  ],
};

/** Words whose own members are others for each: what they are. Another is chosen in the document itself. */
const KINDS = {
  kind: {
    hollow_ball: "hollow ball", solid_ball: "solid ball", ball: "ball", cylinder: "cylinder", capsule: "capsule", box: "box", block: "block", layered_block: "block of layers",
    limb_segment: "limb segment", stl: "closed surface of a file", explicit: "explicit: many short steps", implicit: "implicit: fewer long steps", auto: "whichever takes less time",
    quasi_static: "slowly, without inertia", spherical_inflation: "inflated as a ball", affine: "stretched evenly", pressure: "pressure", traction: "force on a surface",
    mesh: "along the elements", constant: "constant", cylindrical: "around an axis", arrays: "from the file", centre_line: "along a line", laplace: "from end to end",
    linear: "growing evenly", table: "from a table",
  },
  law: {
    mooney_rivlin: "Mooney–Rivlin", neo_hookean: "neo-Hookean", coupled_neo_hookean: "neo-Hookean, coupled", holzapfel_gasser_ogden: "Holzapfel–Gasser–Ogden (with fibres)", yeoh: "Yeoh",
    demiray: "Demiray", veronda_westmann: "Veronda–Westmann", ogden: "Ogden", weiss_transversely_isotropic: "Weiss (one family of fibres)", fung_orthotropic: "Fung, orthotropic",
    blatz_ko: "Blatz–Ko (foam)", balzani: "Balzani (with fibres)", peng_guo_moran: "Peng–Guo–Moran (with fibres)",
  },
};

/** The choices that a member or an entry of a list of that name has, if `word` is one of them; null for others. */
export function choicesOf(key, word) {
  const options = Object.hasOwn(CHOICES, key) ? CHOICES[key] : [];
  return options.some(([one]) => one === word) ? options : null;
}

/** What a word is that other members depend on, in plain words; null for others. */
export function kindOf(key, word) {
  const names = Object.hasOwn(KINDS, key) ? KINDS[key] : {};
  return Object.hasOwn(names, word) ? names[word] : null;
}

/** Members with three numbers that are along x, y and z. */
const VECTORS = new Set(["axis", "center_m", "directions", "displacement_m", "elements", "grading", "grading_center_m", "gravity_m_per_s2", "half_extents_m", "max_m", "min_m", "normal", "origin_m", "point_m", "points_m", "size_m", "spin_rad_per_s", "top_center_m", "traction_pa", "translation_m", "velocity_m_per_s"]);

/** Whether three numbers under that name are along x, y and z. */
export const isAlongAxes = (key) => VECTORS.has(key);
