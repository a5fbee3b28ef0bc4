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

/** How many digits of a number its error leaves: to the second one of the error, from two to four. */
export function digitsWithin(value, error) {
  if (!(error > 0) || !value) return 4;
  const order = (size) => Math.floor(Math.log10(Math.abs(size)));
  return Math.min(Math.max(order(value) - order(error) + 2, 2), 4);
}

/** A number that people set, without zeros that say nothing. */
export function setting(value) {
  return String(Number(value.toPrecision(6))).replace("-", "−");
}

/** Differences below this fraction of what is compared are of rounding [-]. */
const ROUNDING = 1e-12;

/** A change with its sign; what comes of rounding is none. `scale` is the largest of the numbers that were compared. */
export function change(value, scale, digits = 4) {
  if (Math.abs(value) <= ROUNDING * Math.abs(scale)) return "0";
  return `${value > 0 ? "+" : ""}${number(value, digits)}`;
}

/** Of a number this fraction as error makes it an approximate one [-]. */
const ABOUT = 0.5;

/** How sure a number is: "sure"; "about" so much, where the error exceeds half of it; "unresolved", where the error is as large. */
export function surenessOf(value, error) {
  if (!(error > 0)) return "sure";
  if (error >= Math.abs(value)) return "unresolved";
  return error > ABOUT * Math.abs(value) ? "about" : "sure";
}

/** Words of a number as sure as it is: what is not resolved, or of unknown error, stands in brackets. */
export function asSureAs(words, sureness) {
  if (sureness === "sure") return words;
  return sureness === "about" ? `about ${words}` : `(${words})`;
}

/** A number as sure as its error leaves it. Nothing is known of a number without one. */
export function bracketed(value, error) {
  return asSureAs(number(value), surenessOf(value, error));
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
