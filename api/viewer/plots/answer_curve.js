// One number against speed: computed points with their errors, a proposed curve with its band, and where it crosses a level.

import { svg } from "../dom.js";
import { niceAbove, number, setting } from "../format.js";
import { lineStyle } from "./plot.js";

/** Width and height of the picture: words stay readable on a narrow screen. */
const sizeNow = () => (window.innerWidth < 760 ? [400, 330] : [760, 380]);
const ROOM = { left: 56, right: 16, top: 36, bottom: 52 };
const STEPS = 120;

/** Speeds at which a function of speed goes through a level from below, or null: the first of them. */
function crossing(f, level, [low, high]) {
  let before = f(low);
  for (let i = 1; i <= STEPS; i++) {
    const speed = low + (i * (high - low)) / STEPS;
    const now = f(speed);
    if (before <= level && now > level) return speed - ((now - level) / (now - before)) * ((high - low) / STEPS);
    before = now;
  }
  return null;
}

/**
 * Where a curve crosses a level: {at, from, to}, with the speeds between which it is uncertain; `at` is null where it does not rise through
 * it, `isAbove` says whether all of it is above, and `falls` whether it falls through the level anywhere: then no one speed is an answer.
 * `curve` is {value(speed), error(speed)}.
 */
export function crossingOf(curve, level, range) {
  const at = crossing((v) => curve.value(v), level, range);
  const bound = (sign) => crossing((v) => curve.value(v) + sign * curve.error(v), level, range);
  const sides = Array.from({ length: STEPS + 1 }, (_, i) => curve.value(range[0] + (i * (range[1] - range[0])) / STEPS) > level);
  const isUpAt = (sign, v) => curve.value(v) + sign * curve.error(v) > level;
  return {
    at,
    from: bound(1) ?? (isUpAt(1, range[0]) ? range[0] : null),
    to: bound(-1) ?? (isUpAt(-1, range[1]) ? range[1] : null),
    isAbove: sides.every(Boolean),
    falls: sides.some((isUp, i) => i > 0 && !isUp && sides[i - 1]),
  };
}

/** Lower end of the band of a curve: no less than there can be. */
function lowerOf(curve, speed) {
  return Math.max(curve.value(speed) - curve.error(speed), curve.floor);
}

/** Round numbers from `low` to `high`, about `count` of them. */
function ticks(low, high, count) {
  const step = niceAbove((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/**
 * The picture. `series` [{name, points: [{speed, value, error}], curve: {value, error, floor, range} | null}], `range` of speeds, `axis` {label, unit},
 * `level` a value that is marked or null, with `levelName`.
 */
export function answerCurve({ series, range, axis, level, levelName }) {
  const [width, height] = sizeNow();
  const ends = series.flatMap(({ points, curve }) => [
    ...points.flatMap(({ value, error }) => [Math.max(value - (error ?? 0), curve?.floor ?? -Infinity), value + (error ?? 0)]),
    ...(curve ? curve.range.flatMap((v) => [lowerOf(curve, v), curve.value(v) + curve.error(v)]) : []),
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
    text([8, 18], `${axis.label} [${axis.unit}]`, { "font-weight": 600 }),
  ];
  const marked = level == null ? [] : [
    line([ROOM.left, y(level)], [width - ROOM.right, y(level)], { stroke: "#a4161a", "stroke-width": 1.5, "stroke-dasharray": "7 4" }),
    text([width - ROOM.right - 4, y(level) - 6], levelName, { "text-anchor": "end", fill: "#a4161a" }),
  ];
  const drawn = series.map((one, i) => drawnSeries(one, lineStyle(i).stroke, { x, y, level, line, text }));
  const words = series.map(({ name, points }) => `${name}: ${points.map((p) => `${number(p.value, 3)} ${axis.unit} at ${setting(p.speed)} m/s`).join(", ")}`).join("; ");
  return svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${axis.label} against speed. ${words}`, class: "answer-curve" }, grid, marked, drawn);
}

function drawnSeries({ points, curve }, colour, { x, y, level, line, text }) {
  const parts = [];
  if (curve) {
    const { range } = curve;
    const speeds = Array.from({ length: STEPS + 1 }, (_, i) => range[0] + (i * (range[1] - range[0])) / STEPS);
    const place = (v, value) => `${x(v).toFixed(1)} ${y(value).toFixed(1)}`;
    const upper = speeds.map((v) => place(v, curve.value(v) + curve.error(v)));
    const lower = speeds.map((v) => place(v, lowerOf(curve, v))).reverse();
    parts.push(
      svg("path", { d: `M${[...upper, ...lower].join("L")}Z`, fill: colour, "fill-opacity": 0.14, class: "band" }),
      svg("path", { d: `M${speeds.map((v) => place(v, curve.value(v))).join("L")}`, fill: "none", stroke: colour, "stroke-width": 2, "stroke-dasharray": "6 4", class: "proposed" }),
    );
    const found = level == null ? { at: null } : crossingOf(curve, level, range);
    if (found.at != null && !found.falls) {
      parts.push(
        svg("circle", { cx: x(found.at).toFixed(1), cy: y(level).toFixed(1), r: 7, fill: "none", stroke: colour, "stroke-width": 2.5, class: "crossing" }),
        text([x(found.at) + 10, y(level) + 18], `${number(found.at, 3)} m/s`, { fill: colour, "font-weight": 600 }),
      );
    }
  }
  for (const { speed, value, error } of points) {
    if (error > 0) parts.push(line([x(speed), y(Math.max(value - error, curve?.floor ?? -Infinity))], [x(speed), y(value + error)], { stroke: colour, "stroke-width": 1.6 }));
    parts.push(svg("circle", { cx: x(speed).toFixed(1), cy: y(value).toFixed(1), r: 4.5, fill: colour, stroke: "#fff", "stroke-width": 1.5, class: "computed" }));
  }
  return parts;
}
