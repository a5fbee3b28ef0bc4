// What is shown in space and how: field, colours, range, cut, bodies. One panel for all views of a page.

import { button, checkbox, html, select } from "../dom.js";
import { niceAbove } from "../format.js";
import { FIELDS } from "../mesh/colours.js";
import { boxAround } from "../mesh/cells.js";
import { impactLine } from "../plots/depth_profile.js";
import { mainImpact, resultsOf } from "../summary/headline.js";

/** Fields that the frames of a recording have. */
function fieldsOf(recording) {
  const states = recording.frames.flatMap((frame) => [...frame.bodies.values()]);
  const names = new Set(states.flatMap((state) => Object.keys(state.fields ?? {})));
  return Object.keys(FIELDS).filter((name) => names.has(name));
}

/** Largest magnitude of a field over all frames of the tissue, or of the first body that deforms. */
function largest(recording, field) {
  let top = 0;
  for (const frame of recording.frames) {
    const values = frame.bodies.get(recording.tissue?.name)?.fields?.[field] ?? [];
    for (const value of values) top = Math.max(top, Math.abs(value));
  }
  return top;
}

/** The range of a field that all frames of these runs share: for stress the range of the recording, else a round number above all. */
export function defaultRange(recordings, field) {
  const stress = (recording) => JSON.parse(recording.run.colour_range_pa ?? "[0, 0]")[1];
  const isStress = field === "von_mises_pa" || field === "pressure_pa";
  const top = Math.max(...recordings.map((r) => (isStress && stress(r)) || niceAbove(largest(r, field))));
  return [FIELDS[field].from * top, top];
}

export class ViewSettings {
  element = html("fieldset", { class: "settings" }, html("legend", {}, "View"));
  map = "cividis";
  hidden = new Set();

  constructor(recordings, onChange) {
    this.recordings = recordings;
    this.onChange = onChange;
    const [first] = recordings;
    this.fields = fieldsOf(first).filter((field) => recordings.every((r) => fieldsOf(r).includes(field)));
    this.field = this.fields[0] ?? null;
    this.range = this.field && defaultRange(recordings, this.field);
    this.line = impactLine(first);
    this.#setUpCut(first);
    this.#fill();
  }

  /** The cut begins across the longest side of the tissue, through the impact. */
  #setUpCut(recording) {
    if (!recording.tissue) return;
    this.box = boxAround(recording.tissue.X);
    const { low, high } = this.box;
    const sizes = low.map((l, k) => (this.line && Math.abs(this.line.direction[k]) > 0.7 ? 0 : high[k] - l));
    this.cutAxis = sizes.indexOf(Math.max(...sizes));
    this.centre = this.line?.centre ?? low.map((l, k) => (l + high[k]) / 2);
    this.isCut = true;
    this.offset = this.#initialOffset();
  }

  /** Through the impact, but not through the nodes that often lie in the plane of symmetry. */
  #initialOffset() {
    const { low, high } = this.box;
    return this.centre[this.cutAxis] + 0.004 * (high[this.cutAxis] - low[this.cutAxis]);
  }

  /** The plane that cuts, or null: what is on the side of smaller y (or larger x, z) is away. */
  get cut() {
    if (!this.isCut) return null;
    const sign = this.cutAxis === 1 ? -1 : 1;
    return { normal: [0, 1, 2].map((k) => (k === this.cutAxis ? sign : 0)), offset: sign * this.offset };
  }

  /** Sphere and direction of a camera that sees the whole, the cut first. */
  camera() {
    const { low, high } = this.box ?? { low: [-0.1, -0.1, -0.1], high: [0.1, 0.1, 0.1] };
    const sizes = low.map((l, k) => high[k] - l);
    const radius = 0.5 * Math.hypot(...sizes.filter((_, k) => k !== this.cutAxis));
    const middle = low.map((l, k) => (l + high[k]) / 2);
    const centre = this.line ? middle.map((m, k) => 0.45 * m + 0.55 * this.centre[k]) : middle;
    const direction = [[1, -0.35, 0.35], [0.45, -1, 0.4], [0.45, -0.6, 1]][this.cutAxis ?? 1];
    return { centre, radius: radius * 0.8, direction };
  }

  #changed() {
    this.#fill();
    this.onChange();
  }

  #fill() {
    const fields = this.fields.map((name) => [name, FIELDS[name].label]);
    const parts = [
      this.field && select("Colour by", fields, this.field, (field) => {
        this.field = field;
        this.range = defaultRange(this.recordings, field);
        this.#changed();
      }),
      this.field && this.#rangeInputs(),
      select("Colours", [["cividis", "cividis"], ["viridis", "viridis"]], this.map, (map) => ((this.map = map), this.#changed())),
      this.box && this.#cutInputs(),
      this.#bodyInputs(),
    ];
    this.element.replaceChildren(this.element.firstChild, ...parts.filter(Boolean).flat());
  }

  #rangeInputs() {
    const { factor, unit } = FIELDS[this.field];
    const input = (index, label) => {
      const value = Number((this.range[index] * factor).toPrecision(6));
      const box = html("input", { type: "number", step: "any", value, "aria-label": `${label} of the colours${unit ? ` in ${unit}` : ""}`, onchange: () => {
        const wanted = Number(box.value) / factor;
        const next = this.range.map((old, i) => (i === index ? wanted : old));
        if (box.value !== "" && next[0] < next[1]) this.range = next;
        this.#changed();
      } });
      return box;
    };
    return html("div", { class: "field" }, html("span", {}, `Range${unit ? ` [${unit}]` : ""}`), html("span", { class: "pair" }, input(0, "Bottom"), "–", input(1, "Top")));
  }

  #cutInputs() {
    const { low, high } = this.box;
    const axis = this.isCut ? String(this.cutAxis) : "none";
    const choice = select("Cut", [["none", "none"], ["0", "across x"], ["1", "across y"], ["2", "across z"]], axis, (value) => {
      this.isCut = value !== "none";
      if (this.isCut) {
        this.cutAxis = Number(value);
        this.offset = this.#initialOffset();
      }
      this.#changed();
    });
    if (!this.isCut) return [choice];
    const [from, to] = [low[this.cutAxis], high[this.cutAxis]];
    const words = () => `${(this.offset * 1e3).toFixed(1)} mm`;
    const output = html("output", {}, words());
    const slider = html("input", { type: "range", min: from, max: to, step: (to - from) / 200, value: this.offset, "aria-label": "Place of the cut", "aria-valuetext": words(), oninput: () => {
      this.offset = Number(slider.value);
      output.textContent = words();
      slider.setAttribute("aria-valuetext", words());
      this.onChange();
    } });
    return [choice, html("label", { class: "field" }, html("span", {}, "Place of the cut"), html("span", { class: "pair" }, slider, output))];
  }

  #bodyInputs() {
    const names = [...new Set(this.recordings.flatMap((r) => [...r.bodies.keys()]))];
    const boxes = names.map((name) => checkbox(name, !this.hidden.has(name), (isShown) => {
      if (isShown) this.hidden.delete(name);
      else this.hidden.add(name);
      this.onChange();
    }));
    return html("div", { class: "field" }, html("span", {}, "Show"), html("span", { class: "pair" }, boxes));
  }
}

/** The window that forces are averaged over in plots [s]: that of the summary's main impact, or a fiftieth of the run. */
export function forceWindow(summary) {
  return summary && (mainImpact(resultsOf(summary))?.force_window_s || summary.time_s / 50);
}

/** The button that looks at the whole again. */
export function resetButton(onclick) {
  return button("Reset camera", onclick);
}
