// The contact patch, seen along its mean normal, with a scale in millimetres.

import { button, html, saveFile, svg } from "../dom.js";
import { niceAbove, number, withUnit } from "../format.js";

const SIZE = 260;
const MARGIN = 22;

/** The corners of the convex hull of points in the plane, counter-clockwise (Andrew's monotone chain). */
function convexHull(points) {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  if (sorted.length < 3) return sorted;
  const turn = (o, a, b) => (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
  const half = (list) => {
    const chain = [];
    for (const point of list) {
      while (chain.length > 1 && turn(chain.at(-2), chain.at(-1), point) <= 0) chain.pop();
      chain.push(point);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const scaled = (a) => a.map((c) => c / (Math.hypot(...a) || 1));

/** Touching points of one pair in the plane across their mean normal [m], with what they carry; null when nothing touches. */
export function flatPatch(contacts) {
  const count = contacts?.node?.length ?? 0;
  if (!count) return null;
  const at = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];
  const normal = scaled([0, 1, 2].map((k) => contacts.normal.reduce((total, c, i) => (i % 3 === k ? total + c : total), 0)));
  const total = contacts.normal_force_n.reduce((a, b) => a + b, 0) || 1;
  const centre = [0, 1, 2].map((k) => contacts.normal_force_n.reduce((sum, f, i) => sum + f * contacts.position_m[3 * i + k], 0) / total);
  const least = normal.map(Math.abs).indexOf(Math.min(...normal.map(Math.abs)));
  const first = scaled(cross(normal, [0, 1, 2].map((k) => (k === least ? 1 : 0))));
  const second = cross(normal, first);
  const points = Array.from({ length: count }, (_, i) => {
    const position = at(contacts.position_m, i);
    const arm = position.map((c, k) => c - centre[k]);
    return { x: dot(arm, first), y: dot(arm, second), position, force: contacts.normal_force_n[i], isSticking: contacts.status[i] === 1 };
  });
  return { points, normal, centre, hull: convexHull(points) };
}

export class PatchPanel {
  element;
  #picture = html("div", { class: "patch-picture" });
  #words = html("p", { class: "quiet" });
  #extent;
  #name;

  /** `extent` [m]: half the width that is shown, the same at all times. */
  constructor(name, extent) {
    this.#name = name;
    this.#extent = extent;
    this.element = html(
      "figure",
      { class: "patch" },
      html("figcaption", {}, html("strong", {}, "Contact patch"), button("SVG", () => this.#save(), { "aria-label": "Contact patch as SVG" })),
      this.#picture,
      this.#words,
    );
  }

  show(contacts) {
    const patch = flatPatch(contacts);
    const scale = (SIZE / 2 - MARGIN) / this.#extent;
    const children = patch ? this.#drawn(patch, scale) : [svg("text", { x: 0, y: 0, "text-anchor": "middle", class: "patch-none" }, "no contact")];
    const words = patch
      ? `${patch.points.length} nodes touch (● stick, ○ slip; size by force). Area ${withUnit(contacts.area * 1e6, "mm²")}, axes ${number(contacts.axes[0] * 1e3)} × ${number(contacts.axes[1] * 1e3)} mm. Outline: convex hull of the nodes.`
      : "Nothing touches at this time.";
    this.#words.textContent = words;
    this.#picture.replaceChildren(
      svg("svg", { viewBox: `${-SIZE / 2} ${-SIZE / 2} ${SIZE} ${SIZE}`, role: "img", "aria-label": `Contact patch. ${words}`, xmlns: "http://www.w3.org/2000/svg" }, children, this.#scaleBar(scale)),
    );
  }

  #drawn({ points, hull }, scale) {
    const largest = Math.max(...points.map((p) => p.force));
    const place = (p) => `${(p.x * scale).toFixed(2)},${(-p.y * scale).toFixed(2)}`;
    return [
      svg("polygon", { points: hull.map(place).join(" "), fill: "#fbe3d6", stroke: "#d7191c", "stroke-width": 1.6, "stroke-linejoin": "round" }),
      ...points.map((p) => {
        const [cx, cy] = place(p).split(",");
        const radius = 1.6 + 4.4 * Math.sqrt(p.force / largest);
        return svg("circle", { cx, cy, r: radius.toFixed(2), fill: p.isSticking ? "#12344d" : "#fff", stroke: "#12344d", "stroke-width": 1.3 });
      }),
    ];
  }

  #scaleBar(scale) {
    const length = niceAbove(this.#extent / 4);
    const [right, y] = [SIZE / 2 - 12, SIZE / 2 - 12];
    const left = right - length * scale;
    return [
      svg("path", { d: `M${left} ${y - 4}V${y}H${right}V${y - 4}`, fill: "none", stroke: "#12344d", "stroke-width": 1.5 }),
      svg("text", { x: (left + right) / 2, y: y - 6, "text-anchor": "middle", "font-size": 12, fill: "#12344d", "font-family": "system-ui, sans-serif" }, `${number(length * 1e3, 1)} mm`),
    ];
  }

  #save() {
    saveFile(`${this.#name}-contact-patch.svg`, this.#picture.innerHTML, "image/svg+xml");
  }
}
