// What the marks of an answer's picture and its words mean: only those that are there.

import { html } from "../dom.js";
import { ABOUT_MARKS } from "../format.js";

/** The legend of `curves` [{points, curve}]; `hasLevel` where crossings of a level are marked. */
export function answerLegend(curves, hasLevel) {
  const points = curves.flatMap(({ points }) => points);
  const fits = curves.map(({ curve }) => curve).filter(Boolean);
  const isKnown = ({ error }) => error != null;
  const marks = [
    points.some((point) => isKnown(point) && !point.least) && ["●", "computed; its bar is the numerical error"],
    points.some(({ least }) => least) && ["○↑", "computed, a lower bound: at least so much"],
    points.some((point) => !isKnown(point)) && ["◌", "computed, its error unknown: no bar does not mean exact"],
    fits.some(({ isLeast, hasError }) => !isLeast && hasError) && ["┅", "proposed between computed points, with a band of both errors"],
    fits.some(({ isLeast, hasError }) => !isLeast && !hasError) && ["┅", "proposed between computed points; no band, as an error is unknown"],
    fits.some(({ isLeast }) => isLeast) && ["┈", "through lower bounds: at least so much"],
    hasLevel && fits.length > 0 && ["◯", "large: where a curve crosses the top of the layer"],
  ];
  const items = marks.filter(Boolean).map(([mark, words]) => html("li", {}, html("b", { "aria-hidden": "true" }, mark), ` ${words}`));
  return html("ul", { class: "legend-marks quiet", "aria-label": "What the marks mean" }, items, html("li", {}, `In words and table: ${ABOUT_MARKS}`));
}
