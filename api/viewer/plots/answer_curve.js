// One number against speed: computed points with their errors, a proposed curve with its band, and where it crosses a level.

import { html, svg } from "../dom.js";
import { niceAbove, number, setting, within } from "../format.js";
import { lineStyle } from "./plot.js";

/** Width and height of the picture: words stay readable on a narrow screen. */
export const sizeNow = () => (window.innerWidth < 760 ? [400, 310] : [760, 360]);
const ROOM = { left: 56, right: 16, top: 20, bottom: 52 };
const STEPS = 120;

/** The speed between two neighbouring samples of a function at which it is at a level, linear between them. */
function between([v0, f0], [v1, f1], level) {
  return v0 + ((level - f0) / (f1 - f0)) * (v1 - v0);
}

/** A function of speed at equal steps over a range: [speed, value]. */
function sampled(f, [low, high]) {
  return Array.from({ length: STEPS + 1 }, (_, i) => low + (i * (high - low)) / STEPS).map((speed) => [speed, f(speed)]);
}

/** The first speed at which samples are above a level: the start if they are there already; null if they never are. */
function firstAbove(samples, level) {
  const i = samples.findIndex(([, value]) => value > level);
  return i <= 0 ? samples[i]?.[0] ?? null : between(samples[i - 1], samples[i], level);
}

/** The speed from which on samples stay above a level up to their end: the start if they always are; null if they are not above at the end. */
function lastAbove(samples, level) {
  const i = samples.findLastIndex(([, value]) => !(value > level));
  if (i === samples.length - 1) return null;
  return i < 0 ? samples[0][0] : between(samples[i], samples[i + 1], level);
}

/**
 * Where a curve {value(speed), lower(speed), upper(speed)} crosses a level: {at, from, to, isAbove, falls}. `at` is where it rises through the level for the
 * first time, null where it does not. `from` is the first speed at which the upper end of its band is above, `to` the speed from which on
 * the lower end stays above. `isAbove` says whether all of it is above, and `falls` whether it falls through the level anywhere: then no
 * one speed is an answer.
 */
export function crossingOf(curve, level, range) {
  const values = sampled(curve.value, range);
  const falls = values.some(([, value], i) => i > 0 && value <= level && values[i - 1][1] > level);
  const rises = values.findIndex(([, value], i) => i > 0 && value > level && values[i - 1][1] <= level);
  return {
    at: rises < 0 ? null : between(values[rises - 1], values[rises], level),
    from: firstAbove(sampled(curve.upper, range), level),
    to: lastAbove(sampled(curve.lower, range), level),
    isAbove: values.every(([, value]) => value > level),
    falls,
  };
}

/** The speed from which on all points are above 0 by more than their errors; null where the last is not, or its error is not known. */
export function surelyFrom(points) {
  return points[points.findLastIndex(({ lower, error }) => !(error != null && lower > 0)) + 1]?.speed ?? null;
}

/** Half the width of a crossing {at, from, to} with its uncertainty, at the wider side; 0 where that is open. */
export const widthOf = ({ at, from, to }) => Math.max(at - (from ?? at), (to ?? at) - at);

/**
 * Whether a crossing {at, low, high} is an answer over a range of speeds, `low` and `high` the ends of its uncertainty (0 and Infinity where they are
 * open): the uncertainty is less than the speed itself, and excludes a part of the range.
 */
export function isResolvedIn({ at, low, high }, [first, last]) {
  const [from, to] = [Math.max(low, first), Math.min(high, last)];
  return Math.max(at - from, to - at) < at && to - from < (1 - 1e-9) * (last - first);
}

/** Round numbers from `low` to `high`, about `count` of them. */
function ticks(low, high, count) {
  const step = niceAbove((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/**
 * The picture below its title. `series` [{name, points: [{speed, value, error, lower, upper, least}], curve: {value, lower, upper, range, isLeast, hasError} | null}],
 * `range` of speeds, `axis` {label, unit}, `level` a value that is marked or null, with `levelName`; `borders` [{name, at}] of layers, drawn where the
 * numbers reach them.
 */
export function answerCurve({ series, range, axis, level, levelName, borders = [] }) {
  const [width, height] = sizeNow();
  const ends = series.flatMap(({ points, curve }) => [
    ...points.flatMap(({ value, lower, upper, least }) => [lower, least ? value : upper]),
    ...(curve ? [curve.lower, curve.upper].flatMap((end) => sampled(end, curve.range).map(([, value]) => value)) : []),
  ]);
  const values = [...ends, level ?? 0, ...(ends.length ? [] : [1])];
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const pad = 0.06 * (high - low || 1);
  const x = (speed) => ROOM.left + ((speed - range[0]) / (range[1] - range[0])) * (width - ROOM.left - ROOM.right);
  const y = (value) => height - ROOM.bottom - ((value - low + pad) / (high - low + 2 * pad)) * (height - ROOM.top - ROOM.bottom);
  const line = (from, to, attributes) => svg("path", { d: `M${from.map((c) => c.toFixed(1)).join(" ")}L${to.map((c) => c.toFixed(1)).join(" ")}`, fill: "none", ...attributes });
  const text = (at, words, attributes = {}) => svg("text", { x: at[0].toFixed(1), y: at[1].toFixed(1), ...attributes }, words);
  const grid = [
    ...ticks(low - pad, high + pad, 6).map((tick) => [line([ROOM.left, y(tick)], [width - ROOM.right, y(tick)], { stroke: "#e3e8ee" }), text([ROOM.left - 8, y(tick) + 4], setting(tick), { "text-anchor": "end" })]),
    ...ticks(...range, width / 100).map((tick) => [line([x(tick), height - ROOM.bottom], [x(tick), height - ROOM.bottom + 5], { stroke: "#33475b" }), text([x(tick), height - ROOM.bottom + 20], setting(tick), { "text-anchor": "middle" })]),
    line([ROOM.left, height - ROOM.bottom], [width - ROOM.right, height - ROOM.bottom], { stroke: "#33475b" }),
    text([(ROOM.left + width) / 2, height - 12], "speed [m/s]", { "text-anchor": "middle" }),
  ];
  const marked = level == null ? [] : [
    line([ROOM.left, y(level)], [width - ROOM.right, y(level)], { stroke: "#a4161a", "stroke-width": 1.5, "stroke-dasharray": "7 4" }),
    text([width - ROOM.right - 4, y(level) - 6], levelName, { "text-anchor": "end", fill: "#a4161a" }),
  ];
  // Borders of layers beside those that are marked, with the depths beyond which a number is in the next one.
  const isShown = ({ at }) => at !== level && at > low - pad && at < high + pad;
  const layers = borders.filter(isShown).map(({ name, at }) => svg("g", { class: "border" },
    line([ROOM.left, y(at)], [width - ROOM.right, y(at)], { stroke: "#6b7c8f", "stroke-width": 1, "stroke-dasharray": "2 3" }),
    text([ROOM.left + 6, y(at) - 5], name, { fill: "#52606d" })));
  const drawn = series.map((one, i) => drawnSeries(one, lineStyle(i).stroke, { x, y, level, line, text, range }));
  const words = series.map(({ name, points }) => `${name}: ${points.map((p) => pointWords(p, axis.unit)).join(", ")}`).join("; ");
  const picture = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${axis.label} against speed. ${words}`, class: "answer-curve" }, grid, layers, marked, drawn);
  return html("div", {}, html("p", { class: "curve-title" }, `${axis.label} [${axis.unit}]`), picture);
}

/** A computed point in words. */
function pointWords({ speed, value, error, least }, unit) {
  return `${least ? "at least " : ""}${within(value, error)} ${unit} at ${setting(speed)} m/s${error == null ? " (error unknown)" : ""}`;
}

/** How a computed point is drawn: full where its error is known. */
function lookOf({ error, least }, colour) {
  if (error != null && !least) return { fill: colour, stroke: "#fff", "stroke-width": 1.5, class: "computed" };
  const isUnknown = error == null;
  return { fill: "#fff", stroke: colour, "stroke-width": 2, "stroke-dasharray": isUnknown && "2 2", class: `computed${least ? " bound" : ""}${isUnknown ? " unknown" : ""}` };
}

/** A curve with its band, if it has one, and the place where it crosses the level. */
function drawnCurve({ points, curve }, colour, { x, y, level, text, range: asked }) {
  const { range, hasError, isLeast } = curve;
  const place = (v, value) => `${x(v).toFixed(1)} ${y(value).toFixed(1)}`;
  const along = (f) => sampled(f, range).map(([v, value]) => place(v, value));
  const ends = [...along(curve.upper), ...along(curve.lower).reverse()];
  const parts = [
    hasError && svg("path", { d: `M${ends.join("L")}Z`, fill: colour, "fill-opacity": 0.14, class: "band" }),
    svg("path", { d: `M${along(curve.value).join("L")}`, fill: "none", stroke: colour, "stroke-width": 2, "stroke-dasharray": isLeast ? "2 4" : "6 4", class: "proposed" }),
  ];
  const found = level == null ? { at: null } : crossingOf(curve, level, range);
  if (found.at == null || found.falls) return parts;
  const isResolved = isResolvedIn({ at: found.at, low: found.from ?? 0, high: found.to ?? surelyFrom(points) ?? Infinity }, asked);
  const value = hasError ? within(found.at, widthOf(found)) : number(found.at, 2);
  const words = hasError && !isResolved && !isLeast ? "not resolved" : `${isLeast ? "≤ " : ""}${value} m/s${hasError ? "" : ", error unknown"}`;
  return [
    ...parts,
    svg("circle", { cx: x(found.at).toFixed(1), cy: y(level).toFixed(1), r: 7, fill: "none", stroke: colour, "stroke-width": 2.5, class: "crossing" }),
    text([x(found.at) + 10, y(level) + 18], words, { fill: colour, "font-weight": 600 }),
  ];
}

function drawnSeries(one, colour, places) {
  const { points, curve } = one;
  const { x, y, line } = places;
  const parts = curve ? drawnCurve(one, colour, places) : [];
  for (const { speed, value, error, lower, upper, least } of points) {
    const end = least ? value : upper;
    if (end > lower) parts.push(line([x(speed), y(lower)], [x(speed), y(end)], { stroke: colour, "stroke-width": 1.6 }));
    if (least) parts.push(svg("path", { d: arrowUp(x(speed), y(value)), fill: "none", stroke: colour, "stroke-width": 2 }));
    parts.push(svg("circle", { cx: x(speed).toFixed(1), cy: y(value).toFixed(1), r: 4.5, ...lookOf({ error, least }, colour) }));
  }
  return parts;
}

/** An arrow from a place up: what is there is a lower bound. */
function arrowUp(x, y) {
  const [left, right] = [x - 4, x + 4].map((at) => at.toFixed(1));
  const [from, to, back] = [y - 5, y - 20, y - 14].map((at) => at.toFixed(1));
  return `M${x.toFixed(1)} ${from}V${to}M${left} ${back}L${x.toFixed(1)} ${to}L${right} ${back}`;
}
