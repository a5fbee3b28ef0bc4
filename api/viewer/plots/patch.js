// The contact patch, seen along its mean normal: pressure as colours, with a scale in millimetres.

import { button, html, saveFile } from "../dom.js";
import { niceAbove, number, withUnit } from "../format.js";
import { lookupTable } from "../mesh/colours.js";
import { HIGH, highPressure } from "./pressure.js";

/** Side of the picture, edge around the largest patch, and its height with legend [px]; drawn with twice as many. */
const [SIZE, MARGIN, HEIGHT, SHARP] = [260, 16, 300, 2];
/** Where the scale of the colours begins, and its length [px]. */
const [LEFT, LENGTH] = [14, 180];
/** The colour of what is above the range: one that the map has not. */
const ABOVE = [213, 94, 0, 255];

export class PatchPanel {
  element;
  #canvas = html("canvas", { width: SIZE * SHARP, height: HEIGHT * SHARP, role: "img" });
  #words = html("p", { class: "quiet" });
  #extent;
  #top;
  #name;
  #colours = lookupTable("values");

  /** `extent` [m]: half the width that is shown; `top` [Pa]: the end of the colours; both the same at all times. */
  constructor(name, extent, top) {
    this.#name = name;
    this.#extent = extent;
    this.#top = niceAbove(top);
    this.element = html(
      "figure",
      { class: "patch" },
      html("figcaption", {}, html("strong", {}, "Contact pressure"), button("PNG", () => this.#save(), { "aria-label": "Contact pressure as PNG" })),
      this.#canvas,
      this.#words,
    );
  }

  /** Shows a patch with its facets, and the contacts of its pair. */
  show(patch, contacts) {
    const words = patch ? wordsOn(patch, contacts) : "Nothing touches at this time.";
    this.#words.textContent = words;
    this.#canvas.setAttribute("aria-label", `Contact pressure. ${words}`);
    const context = this.#canvas.getContext("2d", { willReadFrequently: true });
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = "#fff";
    context.fillRect(0, 0, this.#canvas.width, this.#canvas.height);
    const scale = (SHARP * (SIZE / 2 - MARGIN)) / this.#extent;
    if (patch) this.#fill(context, patch, scale);
    context.setTransform(SHARP, 0, 0, SHARP, 0, 0);
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = "#16222e";
    if (!patch) {
      context.textAlign = "center";
      context.fillText("no contact", SIZE / 2, SIZE / 2);
    }
    this.#scaleBar(context, scale / SHARP);
    this.#legend(context);
  }

  /** The pressure, point by point; a rigid surface without facets as its touching nodes. */
  #fill(context, { facets, points }, scale) {
    const [width, middle] = [SIZE * SHARP, (SIZE * SHARP) / 2];
    const image = context.getImageData(0, 0, width, width);
    const put = (x, y, pressure) => {
      if (pressure <= 0) return;
      const colour = 4 * Math.floor((255 * pressure) / this.#top);
      image.data.set(pressure > this.#top ? ABOVE : this.#colours.subarray(colour, colour + 4), 4 * (y * width + x));
    };
    for (const facet of facets) rasterise(facet.map(({ x, y, pressure }) => ({ x: middle + x * scale, y: middle - y * scale, pressure })), width, put);
    context.putImageData(image, 0, 0);
    if (facets.length) return;
    context.fillStyle = "#12344d";
    for (const { x, y } of points) {
      context.beginPath();
      context.arc(middle + x * scale, middle - y * scale, 3 * SHARP, 0, 2 * Math.PI);
      context.fill();
    }
  }

  #scaleBar(context, scale) {
    const length = niceAbove(this.#extent / 4);
    const [right, y] = [SIZE - 10, SIZE - 8];
    context.fillRect(right - length * scale, y, length * scale, 2);
    context.textAlign = "right";
    context.fillText(`${number(length * 1e3, 1)} mm`, right, y - 5);
  }

  #legend(context) {
    const y = SIZE + 12;
    const fill = ([r, g, b], x, width) => {
      context.fillStyle = `rgb(${r},${g},${b})`;
      context.fillRect(x, y, width, 8);
    };
    for (let i = 0; i < LENGTH; i++) fill(this.#colours.subarray(4 * Math.floor((255 * i) / LENGTH)), LEFT + i, 1.2);
    fill(ABOVE, LEFT + LENGTH + 16, 16);
    context.fillStyle = "#16222e";
    ["left", "center", "right"].forEach((align, i) => {
      context.textAlign = align;
      context.fillText(`${number(i * 0.5 * this.#top * 1e-3, 2)}${i === 2 ? " kPa" : ""}`, LEFT + 0.5 * LENGTH * i, y + 22);
    });
    context.textAlign = "center";
    context.fillText("above", LEFT + LENGTH + 26, y + 22);
  }

  #save() {
    this.#canvas.toBlob((blob) => saveFile(`${this.#name}-contact-pressure.png`, blob));
  }
}

/** A patch in words: how large, and the pressure that nearly all of it is below. The largest of a node is no result. */
function wordsOn({ points, nodes }, { area, axes }) {
  const size = `${points.length} nodes touch. Area ${withUnit(area * 1e6, "mm²", 3)}, spread over ${number(axes[0] * 1e3, 3)} × ${number(axes[1] * 1e3, 3)} mm`;
  return nodes.length ? `${size}; ${100 * HIGH} % of it has a pressure below about ${withUnit(highPressure(nodes) * 1e-3, "kPa", 2)}, of unknown error.` : `${size}.`;
}

/** Calls `put(x, y, pressure)` for the points of a triangle in a square of this width, linear between its corners. */
function rasterise([a, b, c], width, put) {
  const twice = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  if (Math.abs(twice) < 1e-9) return;
  const [xs, ys] = [[a.x, b.x, c.x], [a.y, b.y, c.y]];
  const [from, to] = [(places) => Math.max(0, Math.ceil(Math.min(...places))), (places) => Math.min(width - 1, Math.max(...places))];
  for (let y = from(ys); y <= to(ys); y++) {
    for (let x = from(xs); x <= to(xs); x++) {
      const v = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / twice;
      const w = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / twice;
      if (v >= 0 && w >= 0 && v + w <= 1) put(x, y, (1 - v - w) * a.pressure + v * b.pressure + w * c.pressure);
    }
  }
}
