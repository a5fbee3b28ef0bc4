// What is shown in space and how: field, colours, range, cut, bodies, deformation. One panel for all views of a page.

import { button, checkbox, html, select } from "../dom.js";
import { setting } from "../format.js";
import { FIELDS } from "../mesh/colours.js";
import { boxAround } from "../mesh/cells.js";
import { approachLine, impactLine, nearestApproach } from "../plots/impact_line.js";
import { mainImpact, resultsOf } from "../summary/headline.js";
import { MODES, firstMode, rangeOf } from "./colour_range.js";

const STRETCHES = [["0", "undeformed"], ["0.5", "× 0.5"], ["1", "as it is"], ["2", "× 2"], ["5", "× 5"]];
/** The first view has this radius: in radii of the projectile, and at least [m]. */
const [AROUND, LEAST] = [2.7, 0.03];
/** What is no farther than so many radii of that view is in it [-]. */
const BEYOND = 1.2;
/** A projectile that is farther has room of so many of its radii [-]. */
const AROUND_FAR = 2;

/** Fields that the frames of a recording have. */
function fieldsOf(recording) {
  const states = recording.frames.flatMap((frame) => [...frame.bodies.values()]);
  const names = new Set(states.flatMap((state) => Object.keys(state.fields ?? {})));
  return Object.keys(FIELDS).filter((name) => names.has(name));
}

function projectileRadius({ bodies }) {
  const body = [...bodies.values()].find((b) => b.role === "projectile");
  if (!body) return 0;
  const { low, high } = boxAround(body.X ?? body.surface.points);
  return 0.5 * Math.max(...low.map((l, k) => high[k] - l));
}

export class ViewSettings {
  /** What is chosen most, and all the rest. */
  element = html("div", { class: "settings-row" });
  details = html("details", { class: "settings" }, html("summary", {}, "Picture settings"));
  #rest = html("div", { class: "settings-grid" });
  mode = "fit";
  hidden = new Set();
  stretch = 1;
  isProjectileColoured = false;
  isFlat = false;

  /** `thresholds` of the stress [Pa]; `onChange(isView)` after something was chosen, with whether it is where the view looks from. */
  constructor(recordings, thresholds, onChange) {
    this.recordings = recordings;
    this.thresholds = thresholds;
    this.onChange = onChange;
    const [first] = recordings;
    this.fields = fieldsOf(first).filter((field) => recordings.every((r) => fieldsOf(r).includes(field)));
    this.line = impactLine(first) ?? approachLine(first);
    this.#setUpCut(first);
    this.details.append(this.#rest);
    this.#choose(this.fields[0] ?? null);
  }

  /** Looks again at recordings that have become longer. */
  refresh() {
    this.line = impactLine(this.recordings[0]) ?? this.line;
    this.#choose(this.field);
  }

  /** Thresholds of the field that is shown. */
  get levels() {
    return this.field === "von_mises_pa" ? this.thresholds : [];
  }

  /** The same in words. */
  get levelNames() {
    const { factor, unit } = FIELDS[this.field] ?? {};
    return this.levels.map((level) => `${setting(level * factor)} ${unit}`);
  }

  get isLog() {
    return this.mode === "log";
  }

  /** The factor on the displacements of a body: projectiles stay where they are. */
  stretchOf(name) {
    return this.recordings[0].bodies.get(name)?.role === "projectile" ? 1 : this.stretch;
  }

  /** The values of a body's nodes that are coloured; null for a plain colour. */
  valuesOf(name, state) {
    const isPlain = this.recordings[0].bodies.get(name)?.role === "projectile" && !this.isProjectileColoured;
    return isPlain ? null : state.fields?.[this.field] ?? null;
  }

  #choose(field) {
    this.field = field;
    if (field) {
      this.mode = firstMode(this.recordings, field, this.levels);
      this.range = rangeOf(this.recordings, field, this.mode, this.levels);
    }
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

  /** Length from the surface to the far side of the tissue, along the impact [m]. */
  get depth() {
    if (!this.box || !this.line) return 0;
    const { low, high } = this.box;
    const { centre, direction } = this.line;
    const ends = direction.map((d, k) => (Math.abs(d) < 1e-6 ? Infinity : ((d > 0 ? high[k] : low[k]) - centre[k]) / d));
    return Math.max(0, Math.min(...ends));
  }

  /** Centre and radius of what is looked at first: around the impact, as far as the largest projectile asks for, or all of the tissue; `isGrown` for a far projectile. */
  #sphere(isWhole) {
    const { low, high } = this.box ?? { low: [-0.1, -0.1, -0.1], high: [0.1, 0.1, 0.1] };
    const whole = 0.5 * Math.hypot(...low.map((l, k) => (k === this.cutAxis ? 0 : high[k] - l)));
    const middle = low.map((l, k) => (l + high[k]) / 2);
    if (isWhole || !this.line) return { centre: middle, radius: whole };
    const radius = Math.min(whole, Math.max(LEAST, ...this.recordings.map((recording) => AROUND * projectileRadius(recording))));
    const centre = this.line.centre.map((c, k) => c + 0.3 * radius * this.line.direction[k]);
    return this.#withProjectile({ centre, radius });
  }

  /** A sphere made larger until it holds the projectile that touches nothing, where that is nearest. */
  #withProjectile({ centre, radius }) {
    const [first] = this.recordings;
    const nearest = impactLine(first) ? null : nearestApproach(first, this.line);
    if (!nearest) return { centre, radius };
    const away = nearest.position.map((c, k) => c - centre[k]);
    const distance = Math.hypot(...away);
    const needed = distance + AROUND_FAR * projectileRadius(first);
    if (needed <= BEYOND * radius) return { centre, radius };
    const grown = (radius + needed) / 2;
    return { centre: centre.map((c, k) => c + ((grown - radius) / distance) * away[k]), radius: grown, isGrown: true };
  }

  /** Sphere and direction of a camera in space that sees the cut first. */
  camera(isWhole = false) {
    return { ...this.#sphere(isWhole), direction: [[1, -0.35, 0.35], [0.45, -1, 0.4], [0.45, -0.6, 1]][this.cutAxis ?? 1] };
  }

  /** The same for a camera that looks straight at the cut. */
  flatCamera(isWhole = false) {
    const { normal } = this.cut ?? { normal: [0, -1, 0] };
    return { ...this.#sphere(isWhole), normal, up: this.line ? this.line.direction.map((d) => -d) : [0, 0, 1] };
  }

  #changed() {
    this.#fill();
    this.onChange();
  }

  #fill() {
    const fields = this.fields.map((name) => [name, FIELDS[name].label]);
    const views = [["space", "in space"], ["flat", "flat section with depth ruler"]];
    this.element.replaceChildren(...[
      this.field && select("Colour by", fields, this.field, (field) => (this.#choose(field), this.onChange())),
      this.line && select("View", views, this.isFlat ? "flat" : "space", (view) => {
        this.isFlat = view === "flat";
        this.isCut ||= this.isFlat;
        this.#fill();
        this.onChange(true);
      }),
    ].filter(Boolean));
    this.#rest.replaceChildren(...[
      this.field && this.#modeInput(),
      this.field && this.#rangeInputs(),
      this.box && this.#cutInputs(),
      select("Deformation of the tissue", STRETCHES, String(this.stretch), (factor) => ((this.stretch = Number(factor)), this.#changed())),
      this.#bodyInputs(),
    ].filter(Boolean).flat());
  }

  #modeInput() {
    const modes = MODES.filter(([mode]) => mode !== "log" || FIELDS[this.field].from === 0);
    return select("Range of the colours", modes, this.mode, (mode) => {
      this.mode = mode;
      this.range = rangeOf(this.recordings, this.field, mode, this.levels);
      this.#changed();
    });
  }

  #rangeInputs() {
    const { factor, unit } = FIELDS[this.field];
    const input = (index, label) => {
      const value = Number((this.range[index] * factor).toPrecision(6));
      const box = html("input", { type: "number", step: "any", value, "aria-label": `${label} of the colours${unit ? ` in ${unit}` : ""}`, onchange: () => {
        const next = this.range.map((old, i) => (i === index ? Number(box.value) / factor : old));
        if (box.value !== "" && next[0] < next[1] && (!this.isLog || next[0] > 0)) this.range = next;
        this.#changed();
      } });
      return box;
    };
    return html("div", { class: "field" }, html("span", {}, `From – to${unit ? ` [${unit}]` : ""}`), html("span", { class: "pair" }, input(0, "Bottom"), "–", input(1, "Top")));
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
      this.#fill();
      this.onChange(this.isFlat);
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
    const names = [...new Set(this.recordings.flatMap((r) => [...r.drawn.keys()]))];
    const boxes = names.map((name) => checkbox(name, !this.hidden.has(name), (isShown) => {
      if (isShown) this.hidden.delete(name);
      else this.hidden.add(name);
      this.onChange();
    }));
    const coloured = checkbox("colour the projectile too", this.isProjectileColoured, (isColoured) => ((this.isProjectileColoured = isColoured), this.onChange()));
    return html("div", { class: "field" }, html("span", {}, "Show"), html("span", { class: "pair" }, boxes, coloured));
  }
}

/** The window that forces are averaged over in plots [s]: that of the summary's main impact, or a tenth of the run. */
export function forceWindow(summary) {
  return summary && (mainImpact(resultsOf(summary))?.force_window_s || summary.time_s / 10);
}

/** The buttons that look at the impact and at the whole again. */
export function cameraButtons(look) {
  return [button("Impact", () => look(false), { title: "Show the impact" }), button("Whole", () => look(true), { title: "Show all of the tissue" })];
}
