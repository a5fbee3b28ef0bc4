// A projectile that nothing moves: the service accepts that as a scene, but it is no impact.

/** What can move a body beside its own velocity: members of a scene, and of a body. */
const [OF_SCENE, OF_BODY] = [["gravity_m_per_s2", "preload", "dynamic_relaxation"], ["prescribed", "face_loads", "initial_deformation", "spin_rad_per_s"]];

/** Whether a member is there and is not zero. */
const isGiven = (value) => (Array.isArray(value) ? value.some((one) => one !== 0) : value != null && value !== 0);

/** A warning {pointer, message, remedy} for each projectile that does not move in a scene in which nothing else does. */
export function stillness(scene) {
  const bodies = Array.isArray(scene?.bodies) ? scene.bodies : [];
  const isMoved = (body) => isGiven(body?.velocity_m_per_s) || OF_BODY.some((member) => isGiven(body?.[member]));
  if (scene?.integrator?.kind === "quasi_static" || OF_SCENE.some((member) => isGiven(scene?.[member])) || bodies.some(isMoved)) return [];
  return bodies.flatMap((body, i) => (body?.role === "projectile" ? [{
    pointer: `/bodies/${i}${body.velocity_m_per_s ? "/velocity_m_per_s" : ""}`, message: "the projectile does not move, and nothing else does", remedy: "give it a velocity",
  }] : []));
}
