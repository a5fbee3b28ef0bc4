// A number with its error: as sure as the error leaves it, the same on every page.

import { html } from "../dom.js";
import { asSureAs, digitsWithin, number, surenessOf, withUnit } from "../format.js";

/** Whether the error of a number was estimated. */
export function hasError({ error }) {
  return error != null && typeof error === "object";
}

/** How sure a number of a summary is: that of [`surenessOf`], or "unknown" where its error was not estimated. */
export function sureness(quantity) {
  if (!hasError(quantity)) return "unknown";
  // Of a peak at a point the program says itself that no mesh resolves it.
  return quantity.error.resolved ? surenessOf(quantity.value, quantity.error.total) : "unresolved";
}

/** Whether a number is larger than its error. */
export function isResolved(quantity) {
  return ["sure", "about"].includes(sureness(quantity));
}

/** A number to the digits that its error leaves, without any remark. */
export function digitsOf({ value, error }) {
  return number(value, digitsWithin(value, error?.total));
}

/** A number as text: about so much where its error exceeds half of it, in brackets where it is not resolved. */
export function bracketed(quantity) {
  return asSureAs(digitsOf(quantity), sureness(quantity));
}

/** The error of a number as text. */
export function errorWords(quantity, unit) {
  if (!hasError(quantity)) return `error ${quantity.error ?? "not estimated"}`;
  return `± ${withUnit(quantity.error.total, unit, 2)}`;
}

/** A number with its error for a cell of a table. */
export function numberWithError(quantity, unit = "") {
  const sure = sureness(quantity);
  const remark = sure === "unresolved" ? ", not resolved" : "";
  return html("span", { class: sure === "sure" ? "number" : "number unsure" }, `${bracketed(quantity)} ${errorWords(quantity, unit)}${remark}`);
}
