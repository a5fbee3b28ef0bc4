// A scene of an uploaded mesh or scan: the first scene of the service, with what the reader has chosen in the places that it leaves open.

/** Uses of a part beside the materials of the library. */
export const [FIXED, STIFF, OMITTED, GIVEN] = ["fixed", "stiff", "omitted", "given"];

/** A stand-in for bone that moves: a thousand times stiffer in shear than tissue, and not so stiff that explicit steps get shorter. */
const STIFF_PART = { density_kg_per_m3: 1800, material: { law: "neo_hookean", c10_pa: 2.5e7, bulk_modulus_pa: 1e8 } };

/** Gap between projectile and target at the start [m]; the surface of a scan is not where its voxels end, by a part of an element. */
const [GAP, GAP_OF_ELEMENT] = [5e-5, 0.1];
const FIELD_TIMES = 24;
/** Threshold of stress whose depth is measured [Pa]. */
const THRESHOLD = 1e4;

/** The body of a first scene that is hit. */
export const tissueOf = (scene) => scene.bodies.find(({ role }) => role === "tissue");

/** Whether a body is made of the labels of a scan. */
export const isScan = (body) => Boolean(body.mesh.segmentation);

/** The use of a part in the first scene: what the service has guessed, or nothing. */
export function guessOf(scene, name) {
  if (tissueOf(scene).mesh.segmentation?.labels.some(({ hole }) => hole === name)) return FIXED;
  const part = scene.bodies.flatMap(({ parts = [] }) => parts).find(({ part }) => part === name);
  if (part?.material.law) return GIVEN;
  const set = part?.material.library;
  return set?.includes("/") ? set : "";
}

/** The body with the uses of its parts; null if nothing of it is left. */
function used(body, parts, { uses, size, near, touch, held }) {
  const kept = [...new Set(parts.map(({ part }) => part))].filter((name) => uses.get(name) !== OMITTED && uses.get(name) !== FIXED);
  const own = isScan(body) ? kept : kept.filter((name) => body.parts.some(({ part }) => part === name));
  if (!own.length) return null;
  const made = own.map((part) => {
    if (uses.get(part) === GIVEN) return body.parts.find((given) => given.part === part);
    return { part, ...(uses.get(part) === STIFF ? STIFF_PART : { material: { library: uses.get(part) } }) };
  });
  const { fixed: _, ...rest } = body;
  if (!isScan(body)) {
    const mesh = own.length === body.parts.length ? body.mesh : { file: { ...body.mesh.file, parts: own } };
    return { ...rest, mesh, parts: made, ...(body.role === "tissue" ? fixedAt(held) : {}) };
  }
  const labels = parts.map(({ label, part }) => ({ label, ...(uses.get(part) === FIXED ? { hole: part } : uses.get(part) === OMITTED ? {} : { part }) }));
  const finer = near.size < size ? { near: [{ point_m: touch.point_m, size_m: near.size, within_m: near.within }] } : {};
  const holes = [...new Set(labels.flatMap(({ hole }) => hole ?? []))];
  const segmentation = { ...body.mesh.segmentation, labels, size_m: size, ...finer };
  return { ...rest, mesh: { segmentation }, parts: made, ...fixedAt([...holes, ...held]) };
}

const fixedAt = (sets) => (sets.length ? { fixed: sets.map((set) => ({ set })) } : {});

/** The projectile, `gap` before the place where it touches. */
function projectileAt({ projectile, touch, speed }, gap) {
  const start = touch.center_m.map((x, k) => Number((x - gap * touch.direction[k]).toPrecision(9)));
  const { rigid, placement: _, ...body } = projectile.body(0, speed);
  const placed = rigid ? { rigid: { ...rigid, center_m: start } } : { placement: { translation_m: start } };
  return { ...body, ...placed, velocity_m_per_s: touch.direction.map((x) => x * speed || 0) };
}

/**
 * The scene of what was chosen: `first` the answer of the service, `uses` by part, `held` sets, `projectile`, `touch`, `speed` [m/s],
 * `end` [s], `accuracy` or none; of a scan `size` of its elements and `near`, {size, within}, at the impact [m].
 */
export function ownScene(chosen) {
  const { first, name, file, end, accuracy } = chosen;
  const targets = first.scene.bodies.filter(({ role }) => role !== "projectile").map((body) => used(body, first.parts, chosen));
  const scan = isScan(tissueOf(first.scene));
  const gap = GAP + (scan ? GAP_OF_ELEMENT * Math.min(chosen.near.size, chosen.size) : 0);
  return {
    name, description: `${chosen.projectile.name} on ${file}`, end_time_s: end,
    bodies: [projectileAt(chosen, gap), ...targets.filter(Boolean)],
    contact: { friction: 0.3 },
    record: { field_interval_s: Number((end / FIELD_TIMES).toPrecision(3)), fields: ["von_mises"] },
    measures: { ...(scan ? { skin_set: "outer" } : {}), stress_thresholds_pa: [THRESHOLD] },
    ...(accuracy ? { accuracy } : {}),
  };
}
