// One number against speed: computed points with their errors, a proposed curve with its band, and where it crosses a level.

import { html, svg } from "../dom.js";
import { exceeds, niceAbove, number, setting, within } from "../format.js";
import { isResolvedIn, markedCrossing, sampled, surelyFrom, widthOf } from "./crossing.js";
import { LabelPlaces } from "./label_places.js";
import { lineStyle } from "./plot.js";

/** Width and height of the picture: words stay readable on a narrow screen. */
export const sizeNow = () => (window.innerWidth < 760 ? [400, 310] : [760, 360]);
const ROOM = { left: 56, right: 16, top: 20, bottom: 52 };
/** What is free above and below all numbers, for a label [units of the picture]. */
const OF_LABEL = 20;
/** Borders beyond the numbers are drawn as far as this part of their range [-]. */
const NEAR = 0.06;
/** Radii of a computed point and of a crossing, and length of the arrow of a lower bound [units of the picture]. */
const [POINT, CROSSING, ARROW] = [4.5, 7, 20];

/** By how much the marks of a series stand to the right of those of the series before [units of the picture]: they would cover each other. */
const ASIDE = 6;
/** How much of the colour is left to a point that is not resolved [-]. */
const PALE = 0.5;

/** Round numbers from `low` to `high`, about `count` of them. */
function ticks(low, high, count) {
  const step = niceAbove((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/** All numbers that the picture of a series must have room for. */
function extentOf({ points, curve }) {
  const computed = points.flatMap(({ value, lower, upper, least }) => [lower, least ? value : upper]);
  if (!curve) return computed;
  const along = (f, range) => sampled(f, range).map(([, value]) => value);
  const band = curve.stretches.flatMap((stretch) => [curve.lower, curve.upper].flatMap((end) => along(end, stretch)));
  return [...computed, ...along(curve.value, curve.range), ...band];
}

const path = (places) => `M${places.map((place) => place.map((c) => c.toFixed(1)).join(" ")).join("L")}`;
const line = (from, to, attributes) => svg("path", { d: path([from, to]), fill: "none", ...attributes });
const text = (at, words, attributes = {}) => svg("text", { x: at[0].toFixed(1), y: at[1].toFixed(1), ...attributes }, words);
/** Words that nothing runs through, at a place {x, y, isEnd}. */
const label = ({ x, y, isEnd }, words, attributes) => text([x, y], words, { "text-anchor": isEnd ? "end" : null, class: "label", ...attributes });

/** Lines of the scales and their numbers. */
function gridOf({ x, y, width, height, low, high }, range) {
  const bottom = height - ROOM.bottom;
  return [
    ...ticks(low, high, 6).map((tick) => [line([ROOM.left, y(tick)], [width - ROOM.right, y(tick)], { stroke: "#e3e8ee" }), text([ROOM.left - 8, y(tick) + 4], setting(tick), { "text-anchor": "end" })]),
    ...ticks(...range, width / 100).map((tick) => [line([x(tick), bottom], [x(tick), bottom + 5], { stroke: "#33475b" }), text([x(tick), bottom + 20], setting(tick), { "text-anchor": "middle" })]),
    line([ROOM.left, bottom], [width - ROOM.right, bottom], { stroke: "#33475b" }),
    text([(ROOM.left + width) / 2, height - 12], "speed [m/s]", { "text-anchor": "middle" }),
  ];
}

/**
 * The scales of a picture: {x(speed), y(value), width, height, low, high, shown}, with room for a label beyond all that is drawn. `shown` are the borders beside
 * the level that numbers reach, or nearly.
 */
function scalesOf({ series, range, level, borders = [] }) {
  const [width, height] = sizeNow();
  const ends = series.flatMap(extentOf);
  const values = [...ends, level ?? 0, ...(ends.length ? [] : [1])];
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const near = NEAR * (most - least);
  const shown = borders.filter(({ at }) => at !== level && at > least - near && at < most + near);
  const [first, last] = [Math.min(least, ...shown.map(({ at }) => at)), Math.max(most, ...shown.map(({ at }) => at))];
  const heightOfPlot = height - ROOM.top - ROOM.bottom;
  const pad = (OF_LABEL / (heightOfPlot - 2 * OF_LABEL)) * (last - first || 1);
  const [low, high] = [first - pad, last + pad];
  const x = (speed) => ROOM.left + ((speed - range[0]) / (range[1] - range[0])) * (width - ROOM.left - ROOM.right);
  const y = (value) => height - ROOM.bottom - ((value - low) / (high - low)) * heightOfPlot;
  return { x, y, width, height, low, high, shown };
}

/**
 * The picture below its title. `answer` {series, range, axis, level, levelName, borders}: `series` [{name, points: [{speed, value, error, lower, upper, least}],
 * curve: {value, lower, upper, range, isLeast, stretches} | null}], `range` of speeds, `axis` {label, unit}, `level` a value that is marked or null, with
 * `levelName`; `borders` [{name, at}] of layers, drawn where the numbers reach them.
 */
export function answerCurve(answer) {
  const { series, range, axis, level, levelName } = answer;
  const scales = scalesOf(answer);
  const { x, y, width, height, shown } = scales;
  const across = (at, attributes) => line([ROOM.left, y(at)], [width - ROOM.right, y(at)], attributes);
  const lines = [
    ...shown.map(({ at }) => across(at, { stroke: "#6b7c8f", "stroke-width": 1, "stroke-dasharray": "2 3" })),
    level != null && across(level, { stroke: "#a4161a", "stroke-width": 1.5, "stroke-dasharray": "7 4" }),
  ];
  const drawn = series.map((one, i) => drawnSeries(one, lineStyle(i).stroke, { x, y, level, aside: i * ASIDE }));
  // Labels, above all that is drawn: first of what is marked, then of the layers, where there is room.
  const places = placesIn(scales, series, level);
  const marked = level == null ? [] : [
    label(places.alongLine(levelName, y(level), true), levelName, { fill: "#a4161a" }),
    series.map((one, i) => crossingLabel(one, lineStyle(i).stroke, { x, y, level, range, places })),
  ];
  const layers = shown.map(({ name, at }) => svg("g", { class: "border" }, label(places.alongLine(name, y(at)), name, { fill: "#52606d" })));
  const words = series.map(({ name, points }) => `${name}: ${points.map((p) => pointWords(p, axis.unit)).join(", ")}`).join("; ");
  const attributes = { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${axis.label} against speed. ${words}`, class: "answer-curve" };
  const picture = svg("svg", attributes, gridOf(scales, range), lines, drawn, marked, layers);
  return html("div", {}, html("p", { class: "curve-title" }, `${axis.label} [${axis.unit}]`), picture);
}

/** The places for labels that are left by curves, points with their bars and arrows, crossings of `level`, and lines at that and at the borders that are shown. */
function placesIn({ x, y, width, height, shown }, series, level) {
  const room = { left: ROOM.left, right: width - ROOM.right, top: 0, bottom: height - ROOM.bottom };
  const places = new LabelPlaces(room);
  [...shown.map(({ at }) => at), level].filter((at) => at != null).forEach((at) => places.keepLine([[room.left, y(at)], [room.right, y(at)]]));
  series.forEach(({ points, curve }, i) => {
    if (curve) places.keepLine(sampled(curve.value, curve.range).map(([speed, value]) => [x(speed), y(value)]));
    const crossing = markedCrossing(curve, level);
    if (crossing) places.keepMark([x(crossing.at), y(level)], CROSSING);
    for (const { speed, value, lower, upper, least } of points) {
      const at = x(speed) + i * ASIDE;
      places.keepMark([at, y(value)], POINT);
      places.keepLine([[at, y(lower)], [at, least ? y(value) - ARROW : y(upper)]]);
    }
  });
  return places;
}

/** A computed point in words. */
function pointWords({ speed, value, error, least }, unit) {
  return `${least ? "at least " : ""}${within(value, error)} ${unit} at ${setting(speed)} m/s${error == null ? " (error unknown)" : ""}`;
}

/** Whether a computed value is known no better than its error, which is known. */
const isUnresolved = ({ value, error, least }) => error != null && !least && !exceeds(value, error);

/** How a computed point is drawn: full where its error is known and smaller than the value. */
function lookOf(point, colour) {
  const { error, least } = point;
  if (isUnresolved(point)) return { fill: "#fff", stroke: colour, "stroke-width": 2, "stroke-opacity": PALE, class: "computed unresolved" };
  if (error != null && !least) return { fill: colour, stroke: "#fff", "stroke-width": 1.5, class: "computed" };
  const isUnknown = error == null;
  return { fill: "#fff", stroke: colour, "stroke-width": 2, "stroke-dasharray": isUnknown && "2 2", class: `computed${least ? " bound" : ""}${isUnknown ? " unknown" : ""}` };
}

/** A curve with its band where its errors are known, and the place where it crosses the level. */
function drawnCurve(curve, colour, { x, y, level }) {
  const { range, stretches, isLeast } = curve;
  const along = (f, over) => sampled(f, over).map(([speed, value]) => [x(speed), y(value)]);
  const band = stretches.map((stretch) => `${path([...along(curve.upper, stretch), ...along(curve.lower, stretch).reverse()])}Z`);
  const crossing = markedCrossing(curve, level);
  return [
    band.length > 0 && svg("path", { d: band.join(""), fill: colour, "fill-opacity": 0.14, class: "band" }),
    svg("path", { d: path(along(curve.value, range)), fill: "none", stroke: colour, "stroke-width": 2, "stroke-dasharray": isLeast ? "2 4" : "6 4", class: "proposed" }),
    crossing && svg("circle", { cx: x(crossing.at).toFixed(1), cy: y(level).toFixed(1), r: CROSSING, fill: "none", stroke: colour, "stroke-width": 2.5, class: "crossing" }),
  ];
}

/** The speed of a crossing, beside its mark; null where there is none. */
function crossingLabel({ points, curve }, colour, { x, y, level, range: asked, places }) {
  const found = markedCrossing(curve, level);
  if (!found) return null;
  const { at, from, to, hasError } = found;
  const isResolved = isResolvedIn({ at, low: from ?? 0, high: to ?? surelyFrom(points) ?? Infinity }, asked);
  const value = hasError ? within(at, widthOf(found)) : number(at, 2);
  const words = hasError && !isResolved && !curve.isLeast ? "not resolved" : `${curve.isLeast ? "≤ " : ""}${value} m/s${hasError ? "" : ", error unknown"}`;
  const place = places.besideMark(words, [x(at), y(level)]);
  const leader = place.isFar && line(...leaderOf(place, [x(at), y(level)]), { stroke: colour, "stroke-width": 1, class: "leader" });
  return [leader, label(place, words, { fill: colour, "font-weight": 600 })];
}

/** Both ends of the line from a mark to its label, which stands away from it. */
function leaderOf(place, [x, y]) {
  const [side, down] = [Math.sign(place.x - x), Math.sign(place.y - y)];
  return [[x, y + down * CROSSING], [place.x - 3 * side, place.y - 4]];
}

function drawnSeries({ points, curve }, colour, scales) {
  const { y, aside } = scales;
  const x = (speed) => scales.x(speed) + aside;
  const parts = curve ? drawnCurve(curve, colour, scales) : [];
  for (const point of points) {
    const { speed, value, lower, upper, least } = point;
    const end = least ? value : upper;
    if (end > lower) parts.push(line([x(speed), y(lower)], [x(speed), y(end)], { stroke: colour, "stroke-width": 1.6, "stroke-opacity": isUnresolved(point) && PALE }));
    if (least) parts.push(svg("path", { d: arrowUp(x(speed), y(value)), fill: "none", stroke: colour, "stroke-width": 2 }));
    parts.push(svg("circle", { cx: x(speed).toFixed(1), cy: y(value).toFixed(1), r: POINT, ...lookOf(point, colour) }));
  }
  return parts;
}

/** An arrow from a place up: what is there is a lower bound. */
function arrowUp(x, y) {
  const [left, right] = [x - 4, x + 4].map((at) => at.toFixed(1));
  const [from, to, back] = [y - 5, y - ARROW, y - 14].map((at) => at.toFixed(1));
  return `M${x.toFixed(1)} ${from}V${to}M${left} ${back}L${x.toFixed(1)} ${to}L${right} ${back}`;
}
