// Units of a scene document, and those in which people set them: millimetres, grams, milliseconds, kilopascals.

import { plainName } from "./plain_names.js";

/** Ends of names, those that contain others first: [end, shown unit, shown number of one SI unit]. */
const UNITS = [
  ["_kg_per_m3", "kg/m³", 1], ["_j_per_m3", "J/m³", 1], ["_j_per_m2", "J/m²", 1], ["_m_per_s2", "m/s²", 1], ["_m_per_s", "m/s", 1], ["_rad_per_s", "rad/s", 1],
  ["_n_per_m", "N/m", 1], ["_pa_s", "Pa s", 1], ["_m3", "mm³", 1e9], ["_deg", "°", 1], ["_pa", "kPa", 1e-3], ["_kg", "g", 1e3], ["_m", "mm", 1e3], ["_s", "ms", 1e3],
  ["_n", "N", 1], ["_j", "J", 1],
];
/** Times of the computer, not of the impact, are in seconds. */
const WALL = /^(time_budget|deadline)_s$/;

/** Whether a field is a time of the computer. */
export const isOfComputer = (key) => WALL.test(key);

function unitOf(key) {
  if (isOfComputer(key)) return ["_s", "s", 1];
  return UNITS.find(([end]) => key.endsWith(end) && key.length > end.length);
}

/** A name of the document as plain words, with the unit that is shown: `outer_radius_m` → outer radius [mm]. */
export function words(key) {
  const unit = unitOf(key);
  const name = plainName(unit ? key.slice(0, -unit[0].length) : key);
  return unit ? `${name} [${unit[1]}]` : name;
}

/** A number of the document as it is shown. */
export function shown(key, value) {
  if (typeof value !== "number") return String(value ?? "");
  return String(Number((value * (unitOf(key)?.[2] ?? 1)).toPrecision(12)));
}

/** SI units in texts of the service, and what stands for them in the form: [unit or its name, factor, unit in the form]. */
const IN_TEXTS = [["m", 1e3, "mm"], ["metres", 1e3, "mm"], ["kg", 1e3, "g"], ["kilograms", 1e3, "g"], ["s", 1e3, "ms"], ["seconds", 1e3, "ms"], ["Pa", 1e-3, "kPa"], ["m³", 1e9, "mm³"]];
const NUMBER = String.raw`[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?`;
const WITH_UNIT = new RegExp(String.raw`(${NUMBER})((?: to (?:${NUMBER}))?) (m|kg|s|Pa|m³)(?![\w/²³])`, "g");
const NAMED_UNIT = new RegExp(String.raw`\bin (metres|seconds|kilograms|m³|m|kg|s|Pa)(?![\w/²³])((?: \([^)]*\))?)`, "g");
/** How a number is converted to SI, in a remedy: the form does that itself. */
const CONVERSION = /(\bin (?:metres|seconds|kilograms|m³|m|kg|s|Pa)): [^;]+? is [\d.e+-]+/g;
const NAME = /`?\b((?:[a-z]\w*\.)*[a-z]\w*_\w+)\b`?/g;

const VECTOR_WITH_UNIT = /\(([-−\d.e+, ]+)\) (m|kg|s|Pa)(?![\w/²³])/g;
/** A number with something else than the unit of its field behind it. */
const WITH_OTHER_UNIT = /\d (?!(?:and|to|or)\b)[A-Za-zµ°%]/;

function converted(text, factor) {
  const value = Number((Number(text.replace("−", "-")) * factor).toPrecision(6));
  return Math.abs(value) >= 1e7 ? value.toExponential().replace("e+", "e") : String(value);
}
/** The numbers of a text that belong to no word, times a factor. */
const allConverted = (text, factor) => text.replace(new RegExp(String.raw`(?<![\w.])${NUMBER}(?![\w.%])`, "g"), (one) => converted(one, factor));

/** A text of the service on a scene in the words and units of the form; `key` is the field that a `limit` is about, whose numbers have no unit. */
export function inForm(text, key = null) {
  const own = key && unitOf(key);
  // A time of the computer is in seconds there, too.
  if (own && isOfComputer(key)) return (/^[<>]=? [\d.]+$/.test(text) ? `${text} s` : text).replace(NAME, (_, name) => quoted(name));
  const factorOf = (unit) => IN_TEXTS.find(([name]) => name === unit);
  const given = text.replace(CONVERSION, "$1")
    .replace(VECTOR_WITH_UNIT, (_, vector, unit) => `(${allConverted(vector, factorOf(unit)[1])}) ${factorOf(unit)[2]}`)
    .replace(/\[(m|kg|s|Pa)\]/g, (_, unit) => `[${factorOf(unit)[2]}]`)
    .replace(WITH_UNIT, (_, one, rest, unit) => {
      const [, factor, shown] = factorOf(unit);
      return `${converted(one, factor)}${allConverted(rest, factor)} ${shown}`;
    })
    .replace(NAMED_UNIT, (_, unit, aside) => {
      const [, factor, shown] = factorOf(unit);
      return `in ${shown}${allConverted(aside, factor)}`;
    });
  const limit = own && given === text && !WITH_OTHER_UNIT.test(text) ? withOwnUnit(text, own) : given;
  return limit.replace(NAME, (_, name) => quoted(name));
}

const withoutUnit = (name) => words(name).replace(/ \[.*/, "");
const quoted = (name) => `“${withoutUnit(name.split(".").at(-1))}”`;

/** A text of the service on a run, with its names of the document as words: those in backticks, those with a unit, and places. */
export function inWords(text) {
  const place = (_, pointer) => {
    const steps = pointer.split("/").filter(Boolean).map((step) => (/^\d+$/.test(step) ? `number ${Number(step) + 1}` : withoutUnit(step)));
    return steps.length ? ` (at ${steps.join(" › ")})` : "";
  };
  return text.replace(/ \(at (\/[^\s)]*)\)/g, place).replace(NAME, (whole, name) => (whole.startsWith("`") || unitOf(name) ? quoted(name) : whole));
}

/** A limit without units in that of its field. */
function withOwnUnit(text, [, unit, factor]) {
  const shown = allConverted(text, factor);
  return /\d/.test(text) ? `${shown} ${unit}` : shown;
}

/** Whether a text is a number. */
export const isNumber = (text) => text.trim() !== "" && Number.isFinite(Number(text.trim().replace(",", ".")));

/** The number that a text means, in SI; what is no number stays the word that it is, for the service to refuse with its place. */
export function meant(key, text) {
  if (!isNumber(text)) return text;
  return Number((Number(text.trim().replace(",", ".")) / (unitOf(key)?.[2] ?? 1)).toPrecision(12));
}
