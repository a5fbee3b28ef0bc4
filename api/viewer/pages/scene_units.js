// Units of a scene document, and those in which people set them: millimetres, grams, milliseconds, kilopascals.

/** Ends of names, those that contain others first: [end, shown unit, shown number of one SI unit]. */
const UNITS = [
  ["_kg_per_m3", "kg/m³", 1], ["_j_per_m3", "J/m³", 1], ["_j_per_m2", "J/m²", 1], ["_m_per_s2", "m/s²", 1], ["_m_per_s", "m/s", 1], ["_rad_per_s", "rad/s", 1],
  ["_n_per_m", "N/m", 1], ["_pa_s", "Pa s", 1], ["_m3", "mm³", 1e9], ["_deg", "°", 1], ["_pa", "kPa", 1e-3], ["_kg", "g", 1e3], ["_m", "mm", 1e3], ["_s", "ms", 1e3],
  ["_n", "N", 1], ["_j", "J", 1],
];
/** Times of the computer, not of the impact, are in seconds. */
const WALL = /^(time_budget|deadline)_s$/;

function unitOf(key) {
  if (WALL.test(key)) return ["_s", "s", 1];
  return UNITS.find(([end]) => key.endsWith(end) && key.length > end.length);
}

/** A name of the document as words, with the unit that is shown: `outer_radius_m` → outer radius [mm]. */
export function words(key) {
  const unit = unitOf(key);
  const name = (unit ? key.slice(0, -unit[0].length) : key).replaceAll("_", " ");
  return unit ? `${name} [${unit[1]}]` : name;
}

/** A number of the document as it is shown. */
export function shown(key, value) {
  if (typeof value !== "number") return String(value ?? "");
  return String(Number((value * (unitOf(key)?.[2] ?? 1)).toPrecision(12)));
}

/** The number that a text means, in SI; what is no number stays the word that it is, for the service to refuse with its place. */
export function meant(key, text) {
  const plain = text.trim().replace(",", ".");
  if (plain === "" || !Number.isFinite(Number(plain))) return text;
  return Number((Number(plain) / (unitOf(key)?.[2] ?? 1)).toPrecision(12));
}
