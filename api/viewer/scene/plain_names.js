// Names of members of a scene document that say little to those who do not write such documents, in plain words; without their units.

const NAMES = {
  accuracy: "required accuracy", angles: "angles of the fibres", between: "between the bodies", bulk_modulus: "stiffness against compression (bulk modulus)", center: "centre",
  damping: "damping", dynamic_relaxation: "relaxation before the impact", elements_along: "elements along", end_time: "time to simulate", error_bars: "errors estimated from",
  every_steps: "checked every so many steps", fibre_frame: "direction of the fibres", field_interval: "time between pictures", field_times: "times of pictures",
  fields: "quantities in the pictures", fixed: "held fixed", force_window: "averaging time of the force", friction: "friction coefficient", generator: "generated shape",
  grading: "largest over smallest element", grading_along: "largest over smallest element, along", grading_around: "largest over smallest element, around",
  grading_muscle: "largest over smallest element, in the muscle", initial_deformation: "deformation at the start", integrator: "time steps", law: "law of the material",
  linear_bulk_viscosity: "damping of sound, linear part", lower_bulk_modulus: "lower stiffness against compression", max: "upper corner", measures: "what is measured", min: "lower corner",
  mu: "stiffness in shear (μ)", lambda: "stiffness against compression (λ)", of: "results that must be accurate", placement: "place", prony_series: "relaxation over time",
  quadratic_bulk_viscosity: "damping of sound, quadratic part", record: "what is recorded", relative: "largest error, as a part of the result", reproducible: "same choice on every machine",
  rigid: "rigid body", role: "what it is in the impact", safety_factor: "part of the largest stable time step", semi_axis_x: "half width", semi_axis_z: "half height",
  bone_semi_axis_x: "half width of the bone", bone_semi_axis_z: "half height of the bone", set: "surface or nodes", shear_viscosity: "viscosity in shear", skin_set: "surface that is the skin",
  solver: "computation", stress_thresholds: "thresholds of stress", time_budget: "time that the run may take", translation: "moved by", uniform_within: "finest elements within",
  valid_to: "valid up to", volumetric: "form of the energy of compression", von_mises: "stress",
};

/** A name without its unit in plain words. */
export const plainName = (name) => (Object.hasOwn(NAMES, name) ? NAMES[name] : name.replaceAll("_", " "));
