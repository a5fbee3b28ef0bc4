// A scene of an uploaded mesh or scan, or of closed surfaces: the first scene of the service, with what the reader has chosen in the places that it leaves open.

/** Uses of a part beside the materials of the library. */
export const [FIXED, STIFF, OMITTED, GIVEN] = ["fixed", "stiff", "omitted", "given"];

/** A stand-in for bone that moves: a thousand times stiffer in shear than tissue, and not so stiff that explicit steps get shorter. */
const STIFF_PART = { density_kg_per_m3: 1800, material: { law: "neo_hookean", c10_pa: 2.5e7, bulk_modulus_pa: 1e8 } };

/** Gap between projectile and target at the start [m]; the surface of a scan is not where its voxels end, by a part of an element. */
const [GAP, GAP_OF_ELEMENT] = [5e-5, 0.25];
const FIELD_TIMES = 24;
/** Lengths of the box around an impact, in diameters of the projectile. */
const CROP = 5;
/** Elements of a first scene across a projectile from which the whole scan is meshed. */
const ELEMENTS_ACROSS = 4;
/** Least size of elements that is proposed [m]. */
const SMALLEST = 1e-3;
/** The part of a skin of given thickness. */
const SKIN = "skin";
/** Threshold of stress whose depth is measured [Pa]. */
const THRESHOLD = 1e4;

/** The body of a first scene that is hit. */
export const tissueOf = (scene) => scene.bodies.find(({ role }) => role === "tissue");

/** Whether a body is filled with elements: made of the labels of a scan, or of closed surfaces. */
export const isFilled = (body) => Boolean(body.mesh.segmentation);

/** What the service found, in another unit: all lengths times a factor. */
export function scaledBy(first, factor) {
  if (factor === 1) return first;
  const times = (x) => Number((x * factor).toPrecision(12));
  const parts = first.parts.map((part) => ({ ...part, volume_m3: part.volume_m3 * factor ** 3, bounding_box_m: part.bounding_box_m.map((corner) => corner.map(times)) }));
  const scaled = (value, keys) => ({ ...value, ...Object.fromEntries(keys.filter((key) => value[key]).map((key) => [key, times(value[key])])) });
  const bodies = first.scene.bodies.map((body) => {
    if (!isFilled(body)) return { ...body, placement: { ...body.placement, scale: times(body.placement?.scale ?? 1) } };
    const { surfaces, ...sizes } = body.mesh.segmentation;
    const files = surfaces.map((surface) => ({ ...surface, scale: times(surface.scale ?? 1) }));
    return { ...body, mesh: { segmentation: { ...scaled(sizes, ["size_m", "thin_size_m", "voxel_size_m"]), surfaces: files } } };
  });
  return { ...first, parts, scene: { ...first.scene, bodies } };
}

/** The use of a part in the first scene: what the service has guessed, or nothing. */
export function guessOf(scene, name) {
  const { labels, surfaces } = tissueOf(scene).mesh.segmentation ?? {};
  if ((labels ?? surfaces)?.some(({ hole }) => hole === name)) return FIXED;
  const part = scene.bodies.flatMap(({ parts = [] }) => parts).find(({ part }) => part === name);
  if (part?.material.law) return GIVEN;
  const set = part?.material.library;
  return set?.includes("/") ? set : "";
}

/** The box around parts [m]. */
export function boxAround(parts) {
  const corner = (of, end) => [0, 1, 2].map((k) => of(...parts.map(({ bounding_box_m }) => bounding_box_m[end][k])));
  return [corner(Math.min, 0), corner(Math.max, 1)];
}

/** A box around the impact of a projectile that is worth to be all of a scan, and whether its elements would be too large otherwise [m]. */
export function cropFor({ diameter_mm }, { size_m: size }) {
  const length = 0.01 * Math.ceil(CROP * diameter_mm / 10);
  return { size_m: [length, length, length], isNeeded: size > diameter_mm * 1e-3 / ELEMENTS_ACROSS };
}

/** The ends at which a body is cut: those of a scan itself, and those of a crop inside of it. */
export function cutEnds({ parts, sets }, crop) {
  const box = boxAround(parts);
  const isCut = (axis, side) => {
    const end = crop && crop.center_m[axis] + (side - 0.5) * crop.size_m[axis];
    return crop && (side ? end < box[1][axis] : end > box[0][axis]);
  };
  const ends = ["x", "y", "z"].flatMap((axis, k) => [[`${axis}_min`, k, 0], [`${axis}_max`, k, 1]]);
  return ends.filter(([name, k, side]) => sets.includes(name) || isCut(k, side)).map(([name]) => name);
}

/** Whether a crop may have something of a part in it: the box of the part meets it. */
function isWithin(name, parts, crop) {
  const box = boxAround(parts.filter(({ part }) => part === name));
  return !crop || crop.center_m.every((centre, k) => box[1][k] > centre - crop.size_m[k] / 2 && box[0][k] < centre + crop.size_m[k] / 2);
}

/** The size of elements with which a crop has about as many as the first scene of the whole scan [m]. */
export function sizeWithin({ scene, parts }, crop) {
  const { size_m: size } = tissueOf(scene).mesh.segmentation;
  if (!crop) return size;
  const [low, high] = boxAround(parts);
  const left = low.map((from, k) => {
    const [start, end] = [-0.5, 0.5].map((side) => crop.center_m[k] + side * crop.size_m[k]);
    return Math.max(0, Math.min(high[k], end) - Math.max(from, start)) / (high[k] - from);
  });
  return Number(Math.max(SMALLEST, size * Math.cbrt(left[0] * left[1] * left[2])).toPrecision(2));
}

/** The body with the uses of its parts; null if nothing of it is left. */
function used(body, parts, { uses, size, near, touch, held, crop, skin }) {
  const kept = [...new Set(parts.map(({ part }) => part))].filter((name) => uses.get(name) !== OMITTED && uses.get(name) !== FIXED);
  const own = isFilled(body) ? kept.filter((name) => isWithin(name, parts, crop)) : kept.filter((name) => body.parts.some(({ part }) => part === name));
  if (!own.length) return null;
  const made = own.map((part) => {
    if (uses.get(part) === GIVEN) return body.parts.find((given) => given.part === part);
    return { part, ...(uses.get(part) === STIFF ? STIFF_PART : { material: { library: uses.get(part) } }) };
  });
  const { fixed: _, ...rest } = body;
  if (!isFilled(body)) {
    const mesh = own.length === body.parts.length ? body.mesh : { file: { ...body.mesh.file, parts: own } };
    return { ...rest, mesh, parts: made, ...(body.role === "tissue" ? fixedAt(held) : {}) };
  }
  const usage = ({ part }) => (uses.get(part) === FIXED ? { hole: part } : uses.get(part) === OMITTED ? {} : { part });
  // Parts are listed as the surfaces are.
  const { surfaces, thin_size_m: thin, ...given } = body.mesh.segmentation;
  const listed = surfaces
    ? { surfaces: surfaces.map(({ name, scale }, n) => ({ name, ...(scale ? { scale } : {}), ...usage(parts[n]) })), ...(thin < size ? { thin_size_m: thin } : {}) }
    : { labels: parts.map((part) => ({ label: part.label, ...usage(part) })) };
  const finer = near.size < size ? { near: [{ point_m: touch.point_m, size_m: near.size, within_m: near.within }] } : {};
  const holes = [...new Set((listed.surfaces ?? listed.labels).flatMap(({ hole }) => hole ?? []))].filter((hole) => isWithin(hole, parts, crop));
  const segmentation = { ...given, ...listed, size_m: size, ...finer, ...(crop ? { crop } : {}), ...(skin ? { skin_thickness_m: skin.thickness } : {}) };
  if (skin && !own.includes(SKIN)) made.push({ part: SKIN, material: { library: skin.material } });
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
 * `end` [s], `accuracy` or none; of a scan `size` of its elements and `near`, {size, within}, at the impact [m], `crop` or none, `skin`,
 * {thickness, material}, or none.
 */
export function ownScene(chosen) {
  const { first, name, file, end, accuracy } = chosen;
  const targets = first.scene.bodies.filter(({ role }) => role !== "projectile").map((body) => used(body, first.parts, chosen));
  const isOfElements = isFilled(tissueOf(first.scene));
  const gap = GAP + (isOfElements ? GAP_OF_ELEMENT * Math.min(chosen.near.size, chosen.size) : 0);
  return {
    name, description: `${chosen.projectile.name} on ${file}`, end_time_s: end,
    bodies: [projectileAt(chosen, gap), ...targets.filter(Boolean)],
    contact: { friction: 0.3 },
    record: { field_interval_s: Number((end / FIELD_TIMES).toPrecision(3)), fields: ["von_mises"] },
    measures: { ...(isOfElements ? { skin_set: "outer" } : {}), stress_thresholds_pa: [THRESHOLD] },
    ...(accuracy ? { accuracy } : {}),
  };
}
