// Numbers as people read them.

const NARROW_SPACE = "\u202f";

/** A number with so many significant digits, without exponent where that is readable. */
export function number(value, digits = 4) {
  if (value == null || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e7) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${mantissa.replace("-", "−")} × 10${superscript(Number(exponent))}`;
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  // Digits before the point beyond the significant ones would pretend.
  const rounded = decimals > 0 ? value : Number(value.toPrecision(digits));
  return rounded.toFixed(Math.min(decimals, 12)).replace("-", "−");
}

function superscript(exponent) {
  return String(exponent).replace(/./g, (c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]);
}

/** Digits of an error, and of a number at most. */
const [OF_ERROR, MOST] = [2, 4];

/** A number to the decimal place of its error, which has two digits, and to four digits at most; to those where the error is not known. */
export function within(value, error) {
  if (!(error > 0) || !Number.isFinite(value)) return number(value);
  // 0.096 has its second digit where 0.10 has none: what counts is the rounded error.
  const place = Math.floor(Math.log10(Number(error.toPrecision(OF_ERROR)))) - OF_ERROR + 1;
  const digits = value === 0 ? 0 : Math.floor(Math.log10(Math.abs(value))) - place + 1;
  if (digits > MOST) return number(value, MOST);
  const rounded = Math.round(value / 10 ** place) * 10 ** place;
  if (rounded === 0) return "0";
  const isLong = Math.abs(rounded) < 1e-4 || Math.abs(rounded) >= 1e7;
  return isLong ? number(rounded, Math.max(1, digits)) : rounded.toFixed(Math.max(0, -place)).replace("-", "−");
}

/** The end of what is possible, which is known better than the error: three significant digits. */
export const limit = (value) => number(value, 3);

/** A number that people set, without zeros that say nothing. */
export function setting(value) {
  return String(Number(value.toPrecision(6))).replace("-", "−");
}

/** Differences below this fraction of what is compared are of rounding [-]. */
const ROUNDING = 1e-12;

/** A change with its sign, to the decimal place of its `error`; what comes of rounding is none. `scale` is the largest of the numbers that were compared. */
export function change(value, scale, error = null) {
  const words = Math.abs(value) <= ROUNDING * Math.abs(scale) ? "0" : within(value, error);
  return value > 0 && words !== "0" ? `+${words}` : words;
}

/** Whether a number is larger than its error. */
export const exceeds = (value, error) => !(error > 0) || error < Math.abs(value);

/** What each mark of a number means. */
export const ABOUT_BRACKETS = "(12) in brackets: the error is as large as the number, or is unknown, or too few points give the number; at best an order of magnitude.";
export const ABOUT_BOUNDS = "≥ 12: a lower bound, at least so much.";

/** What the marks of a number mean, for a line below a table. */
export const ABOUT_MARKS = `${ABOUT_BRACKETS} ${ABOUT_BOUNDS}`;

/** Words of a number with its doubt: in brackets unless it is resolved, with ≥ where it is a lower bound; one that rounds to zero bounds nothing. */
export function marked(words, isResolved, isLeast = false) {
  const bound = `${isLeast && words !== "0" ? "≥\u00a0" : ""}${words}`;
  return isResolved ? bound : `(${bound})`;
}

/** A number to the decimal place of its error; in brackets where that is as large, or not known. */
export function bracketed(value, error, isLeast = false) {
  return marked(within(value, error), error != null && exceeds(value, error), isLeast);
}

/** A number and its unit. */
export function withUnit(value, unit, digits = 4) {
  return unit ? `${number(value, digits)}${NARROW_SPACE}${unit}` : number(value, digits);
}

/** The unit in which times of a run are read: factor and name. */
export function timeUnit(end) {
  if (end < 1e-3) return { factor: 1e6, name: "µs" };
  return end < 1 ? { factor: 1e3, name: "ms" } : { factor: 1, name: "s" };
}

/** A time that is given [s], in its unit. */
export function timeWords(time) {
  const { factor, name } = timeUnit(time);
  return `${setting(time * factor)}${NARROW_SPACE}${name}`;
}

/** Bytes in the usual prefix. */
export function bytes(count) {
  const prefix = count < 1e3 ? 0 : count < 1e6 ? 1 : count < 1e9 ? 2 : 3;
  return withUnit(count / 1000 ** prefix, ["B", "kB", "MB", "GB"][prefix], 3);
}

/** A moment of the wall clock, in the reader's time zone. */
export function moment(text) {
  return text ? new Date(text).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "medium" }) : "–";
}

/** The smallest of 1, 2, 5 × 10ⁿ that is not below. */
export function niceAbove(value) {
  if (!(value > 0) || !Number.isFinite(value)) return 1;
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * [1, 2, 5, 10].find((factor) => factor * decade >= value * (1 - 1e-12));
}

/** Rows of names and numbers as comma-separated text; null is an empty cell. */
export function commaSeparated(rows) {
  // An apostrophe keeps spreadsheets from reading a name as a formula.
  const plain = (text) => (/^[=+\-@\t\r]/.test(text) ? `'${text}` : text);
  const quoted = (text) => (/[",\n]/.test(text) ? `"${plain(text).replaceAll('"', '""')}"` : plain(text));
  const cell = (value) => (typeof value === "string" ? quoted(value) : value ?? "");
  return `${rows.map((row) => row.map(cell).join(",")).join("\n")}\n`;
}
