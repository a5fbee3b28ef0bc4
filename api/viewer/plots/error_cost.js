// Error against cost of the settings of a study: both on logarithmic scales, the settings that differ by their mesh alone as a line.

import { html, svg } from "../dom.js";
import { number, setting } from "../format.js";

/** Width and height of the picture: words stay readable on a narrow screen. */
const sizeNow = () => (window.innerWidth < 760 ? [400, 330] : [900, 380]);
const ROOM = { left: 72, right: 24, top: 16, bottom: 50 };
/** Errors below this part of the largest are drawn at it [-]. */
const LEAST = 1e-3;
const [OWN, OTHER] = ["#0072b2", "#b34a00"];
/** Height and width of the number of a point [px]. */
const [LINE, WIDTH] = [14, 18];

/** Powers of ten from `low` to `high`. */
function decades(low, high) {
  const first = Math.floor(Math.log10(low) + 1e-9);
  return Array.from({ length: Math.ceil(Math.log10(high) - 1e-9) - first + 1 }, (_, i) => 10 ** (first + i));
}

/**
 * The picture, and what its points are: `points` [{name, cost [s], error [-], isMesh}], `isMesh` those that differ from the scene by their mesh alone, from coarse to
 * fine; `known` the uncertainty of the limit [-], below which errors say nothing, or null.
 */
export function errorCost(points, known, label) {
  const [width, height] = sizeNow();
  const most = Math.max(...points.map(({ error }) => error), known ?? 0) || 1;
  const floor = Math.max(LEAST * most, Number.MIN_VALUE);
  const shown = points.map((point) => ({ ...point, error: Math.max(point.error, floor) }));
  const costs = decades(Math.min(...shown.map(({ cost }) => cost)), Math.max(...shown.map(({ cost }) => cost)));
  const errors = decades(Math.min(...shown.map(({ error }) => error)), most);
  const scale = (values, [from, to]) => (value) => from + ((Math.log10(value) - Math.log10(values[0])) / (Math.log10(values.at(-1)) - Math.log10(values[0]) || 1)) * (to - from);
  const x = scale(costs, [ROOM.left, width - ROOM.right]);
  const y = scale(errors, [height - ROOM.bottom, ROOM.top]);
  const line = (d, attributes) => svg("path", { d, fill: "none", ...attributes });
  const text = (px, py, words, attributes = {}) => svg("text", { x: px.toFixed(1), y: py.toFixed(1), ...attributes }, words);
  const grid = [
    errors.map((tick) => [line(`M${ROOM.left} ${y(tick).toFixed(1)}H${width - ROOM.right}`, { stroke: "#e3e8ee" }), text(ROOM.left - 8, y(tick) + 4, `${setting(100 * tick)} %`, { "text-anchor": "end" })]),
    costs.map((tick) => [line(`M${x(tick).toFixed(1)} ${height - ROOM.bottom}v5`, { stroke: "#33475b" }), text(x(tick), height - ROOM.bottom + 20, `${setting(tick)} s`, { "text-anchor": "middle" })]),
    line(`M${ROOM.left} ${height - ROOM.bottom}H${width - ROOM.right}`, { stroke: "#33475b" }),
    text((ROOM.left + width) / 2, height - 10, "processor time of a run", { "text-anchor": "middle" }),
  ];
  const top = known > floor ? y(Math.min(known, errors.at(-1))) : null;
  const unknown = top == null ? [] : [
    svg("rect", { x: ROOM.left, y: top.toFixed(1), width: width - ROOM.left - ROOM.right, height: (height - ROOM.bottom - top).toFixed(1), fill: "#8fa0b0", "fill-opacity": 0.18 }),
    text(ROOM.left + 6, height - ROOM.bottom - 8, "below the uncertainty of the limit", { fill: "#51606e" }),
  ];
  const meshes = shown.filter(({ isMesh }) => isMesh).map(({ cost, error }) => `${x(cost).toFixed(1)} ${y(error).toFixed(1)}`);
  const words = points.map(({ name, cost, error }) => `${name}: ${number(100 * error, 2)} % in ${number(cost, 2)} s`).join("; ");
  const picture = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", class: "answer-curve error-cost", "aria-label": `Error of ${label} against processor time. ${words}` },
    grid, unknown, meshes.length > 1 ? line(`M${meshes.join("L")}`, { stroke: OWN, "stroke-width": 2 }) : [],
    shown.map(({ cost, error, isMesh }) => svg("circle", { cx: x(cost).toFixed(1), cy: y(error).toFixed(1), r: 5, fill: isMesh ? OWN : OTHER, stroke: "#fff", "stroke-width": 1.5 })),
    numbersAt(shown, x, y, text));
  const item = ({ name, cost, error, isMesh }) => html("li", { class: isMesh ? "of-mesh" : "of-setting" }, `${name}: ${number(100 * error, 2)} % in ${number(cost, 2)} s`);
  return html("div", {}, picture, html("ol", { class: "error-points" }, points.map(item)));
}

/** The numbers of the points above them, none over another. */
function numbersAt(points, x, y, text) {
  const taken = [];
  return points.map(({ cost, error, isMesh }, i) => {
    const from = x(cost);
    const isFree = (at) => taken.every((other) => Math.abs(other.at - at) >= LINE || Math.abs(other.from - from) >= WIDTH);
    const at = [-1, 1.6, -2, 2.6, -3, 3.6].map((k) => y(error) + k * LINE).find((place) => place > 10 && isFree(place)) ?? y(error) - LINE;
    taken.push({ at, from });
    return text(from, at, String(i + 1), { "text-anchor": "middle", "font-weight": 600, fill: isMesh ? OWN : "#8a4b00" });
  });
}
