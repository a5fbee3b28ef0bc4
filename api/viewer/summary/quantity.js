// A number with its error: to the digits that the error leaves, in brackets where it is not resolved; the same on every page.

import { html } from "../dom.js";
import { exceeds, limit, marked, number, within } from "../format.js";

/** Whether the error of a number was estimated. */
export function hasError({ error }) {
  return error != null && typeof error === "object";
}

/** Whether the error of a number is known and smaller than the number. Of a peak at a point the program says itself that no mesh resolves it. */
export function isResolved(quantity) {
  return hasError(quantity) && quantity.error.resolved && exceeds(quantity.value, quantity.error.total);
}

/** A number as text, to the decimal place of its error: in brackets where it is not resolved, with ≥ where it is a lower bound. */
export function digits(quantity) {
  return marked(within(quantity.value, quantity.error?.total), isResolved(quantity), quantity.is_lower_bound);
}

/**
 * The value ± its error within what is possible, by the rule of the summary: {low, high}, `isCutBelow` and `isCutAbove` where an end is what
 * is possible. The value itself is always in it. A lower bound has no end above, `isOpen`.
 */
export function intervalOf({ value, error: { total }, possible: [least, most] = [], is_lower_bound: isOpen = false }) {
  const [low, high] = [value - total, value + total];
  const upper = Math.min(high, Math.max(most ?? Infinity, value));
  const isCutBelow = least != null && low < least && least <= value;
  return { low: isCutBelow ? least : low, high: isOpen ? Infinity : upper, isCutBelow, isCutAbove: !isOpen && upper < high, isOpen };
}

/** The error of a number as text: "± 0.50 J", or "between 5.8 and 8.00 J" and "up to 8.00 J" where it ends at what is possible; of a lower bound that of its lower end. */
export function errorWords(quantity, unit = "") {
  if (!hasError(quantity)) return `error ${quantity.error ?? "not estimated"}`;
  const { total } = quantity.error;
  const { low, high, isCutBelow, isCutAbove, isOpen } = intervalOf(quantity);
  const upper = () => (isCutAbove ? limit(high) : within(high, total));
  const isEven = isOpen || !(isCutBelow || isCutAbove);
  const words = isEven ? `± ${number(total, 2)}` : isCutBelow ? `up to ${upper()}` : `between ${within(low, total)} and ${upper()}`;
  return unit ? `${words}\u202f${unit}` : words;
}

/** A number with its error for a cell of a table. */
export function numberWithError(quantity) {
  const remark = hasError(quantity) && !isResolved(quantity) ? ", not resolved" : "";
  return html("span", { class: isResolved(quantity) ? "number" : "number unsure" }, `${digits(quantity)} ${errorWords(quantity)}${remark}`);
}
