// Words over the picture: names of the layers at the cut and of the lines at thresholds, and in the flat section a ruler of depth.

import * as THREE from "three";
import { svg } from "../dom.js";
import { niceAbove, number } from "../format.js";

/** Least distance of two names from each other, and width of a letter [px]. */
const [LINE, LETTER] = [19, 7.2];
/** Names stand so far below their lines, or above them where bone begins within a line [px]. */
const [BELOW, ABOVE] = [13, -6];

export class Overlay {
  element = svg("svg", { class: "overlay", "aria-hidden": "true" });
  #labels = [];
  #contours = [];
  #ruler = null;

  /** `labels` [{text, at}] in space [m]. */
  setLabels(labels) {
    this.#labels = labels;
  }

  /** Names of lines in the section [{text, at, bone}], in space [m]; `bone` is where bone begins below the line, if it does. */
  setContours(contours) {
    this.#contours = contours;
  }

  /** `ruler` {origin, direction, length} in space [m], or null. */
  setRuler(ruler) {
    this.#ruler = ruler;
  }

  /** Draws over a view of this size [px]. */
  draw(camera, isFlat, width, height) {
    const place = (at) => {
      const p = new THREE.Vector3(...at).project(camera);
      return { x: ((p.x + 1) / 2) * width, y: ((1 - p.y) / 2) * height };
    };
    this.element.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.element.replaceChildren(...this.#drawnLabels(place, width, height), ...this.#drawnContours(place), ...(isFlat && this.#ruler ? this.#drawnRuler(place, height) : []));
  }

  #drawnLabels(place, width, height) {
    const inside = ({ x, y }) => x > 0 && x < width && y > 0 && y < height;
    const labels = this.#labels.map(({ text, at }) => ({ text, ...place(at) })).filter(inside).sort((a, b) => a.y - b.y);
    const longest = Math.max(0, ...labels.map(({ text }) => text.length)) * LETTER;
    const column = width - longest - 14;
    let lowest = 6;
    const rows = labels.map((label) => {
      const at = Math.max(label.y, lowest + LINE / 2);
      lowest = at + LINE / 2;
      return { ...label, at };
    });
    // Those that would leave the picture push the others up.
    let highest = height - LINE / 2;
    for (const row of rows.toReversed()) {
      row.at = Math.min(row.at, highest - LINE / 2);
      highest = row.at - LINE / 2;
    }
    return rows.flatMap(({ text, x, y, at }) => [
      ...["leader wide", "leader"].map((name) => svg("path", { d: `M${x.toFixed(1)} ${y.toFixed(1)}L${column - 14} ${at.toFixed(1)}H${column - 4}`, class: name })),
      svg("circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: 2.6, class: "anchor" }),
      svg("text", { x: column, y: (at + 4.5).toFixed(1), class: "layer-name" }, text),
    ]);
  }

  /** Names below their places, above them where they would lie on bone; of two that would lie on each other the first. */
  #drawnContours(place) {
    const drawn = [];
    return this.#contours.flatMap(({ text, at, bone }) => {
      const { x, y: line } = place(at);
      const y = line + (bone && place(bone).y - line < LINE ? ABOVE : BELOW);
      if (drawn.some((other) => Math.abs(x - other.x) < text.length * LETTER && Math.abs(y - other.y) < LINE)) return [];
      drawn.push({ x, y });
      return [svg("text", { x: x.toFixed(1), y: y.toFixed(1), class: "contour-name" }, text)];
    });
  }

  #drawnRuler(place, height) {
    const { origin, direction, length } = this.#ruler;
    const at = (depth) => place(origin.map((o, k) => o + depth * direction[k])).y;
    const perPixel = length / Math.max(1, Math.abs(at(length) - at(0)));
    const step = niceAbove(46 * perPixel);
    const parts = [svg("path", { d: `M46 ${at(0).toFixed(1)}V${at(length).toFixed(1)}`, class: "ruler" })];
    for (let i = 0; i * step <= length * (1 + 1e-9); i++) {
      const y = at(i * step);
      if (y < 0 || y > height) continue;
      parts.push(
        svg("path", { d: `M38 ${y.toFixed(1)}H46`, class: "ruler" }),
        svg("text", { x: 34, y: (y + 4).toFixed(1), class: "tick" }, number(i * step * 1e3, 2).replace(/\.0+$/, "")),
      );
    }
    parts.push(svg("text", { x: 8, y: Math.max(14, at(0) - 12).toFixed(1), class: "ruler-name" }, "mm straight in, from the surface at rest"));
    return parts;
  }
}
