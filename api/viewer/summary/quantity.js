// A number with its error: to the digits that the error leaves, in brackets where it is not resolved; the same on every page.

import { html } from "../dom.js";
import { exceeds, marked, withUnit, within } from "../format.js";

/** Whether the error of a number was estimated. */
export function hasError({ error }) {
  return error != null && typeof error === "object";
}

/** Whether the error of a number is known and smaller than the number. Of a peak at a point the program says itself that no mesh resolves it. */
export function isResolved(quantity) {
  return hasError(quantity) && quantity.error.resolved && exceeds(quantity.value, quantity.error.total);
}

/** A number as text, to the decimal place of its error: in brackets where it is not resolved, with ≥ where it is a lower bound. */
export function digits(quantity, isLeast = false) {
  return marked(within(quantity.value, quantity.error?.total), isResolved(quantity), isLeast);
}

/** The error of a number as text. */
export function errorWords(quantity, unit = "") {
  if (!hasError(quantity)) return `error ${quantity.error ?? "not estimated"}`;
  return `± ${withUnit(quantity.error.total, unit, 2)}`;
}

/** A number with its error for a cell of a table. */
export function numberWithError(quantity, isLeast) {
  const remark = hasError(quantity) && !isResolved(quantity) ? ", not resolved" : "";
  return html("span", { class: isResolved(quantity) ? "number" : "number unsure" }, `${digits(quantity, isLeast)} ${errorWords(quantity)}${remark}`);
}
