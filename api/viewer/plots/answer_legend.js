// What the marks of an answer's picture and its words mean: only those that are there.

import { html } from "../dom.js";
import { ABOUT_BOUNDS, ABOUT_BRACKETS, exceeds } from "../format.js";
import { isKnownThroughout, markedCrossing } from "./crossing.js";

/** What the curves through computed points have of a band, in words. */
function aboutBand(fits) {
  if (fits.every(isKnownThroughout)) return ", with a band of both errors";
  if (fits.some(({ stretches }) => stretches.length)) return "; a band of both errors between points whose errors are known";
  return "; no band, as errors are unknown";
}

/** The legend of `curves` [{points, curve}], crossings of `level` among their marks unless it is null. */
export function answerLegend(curves, level) {
  const points = curves.flatMap(({ points }) => points);
  const fits = curves.map(({ curve }) => curve).filter(Boolean);
  const proposed = fits.filter(({ isLeast }) => !isLeast);
  const isKnown = ({ error }) => error != null;
  const marks = [
    points.some((point) => isKnown(point) && !point.least && exceeds(point.value, point.error)) && ["●", "computed; its bar is the numerical error"],
    points.some((point) => isKnown(point) && !point.least && !exceeds(point.value, point.error)) && ["○", "pale: computed, not resolved, since the error (the bar) is as large as the number"],
    curves.length > 1 && ["⇥", "points of the second curve stand a little to the right of their speed"],
    points.some(({ least }) => least) && ["○↑", "computed, a lower bound: at least so much"],
    points.some((point) => !isKnown(point)) && ["◌", "computed, its error unknown: no bar does not mean exact"],
    proposed.length > 0 && ["┅", `proposed between computed points${aboutBand(proposed)}`],
    fits.some(({ isLeast }) => isLeast) && ["┈", "through lower bounds: at least so much"],
    fits.some((curve) => markedCrossing(curve, level)) && ["◯", "large: where a curve crosses the top of the layer"],
    points.some((point) => !isKnown(point) || !exceeds(point.value, point.error)) && ["( )", `in words and table: ${ABOUT_BRACKETS}`],
    points.some(({ least }) => least) && ["≥", `in words and table: ${ABOUT_BOUNDS}`],
  ];
  const items = marks.filter(Boolean).map(([mark, words]) => html("li", {}, html("b", { "aria-hidden": "true" }, mark), ` ${words}`));
  return html("ul", { class: "legend-marks quiet", "aria-label": "What the marks mean" }, items);
}
