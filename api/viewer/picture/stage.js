// The picture of a run: mesh with colours, cut, layers, time; what is under the pointer in words.

import { button, html, saveFile } from "../dom.js";
import { withUnit } from "../format.js";
import { FIELDS, Legend } from "../mesh/colours.js";
import { MeshView } from "../mesh/mesh_view.js";
import { Skin } from "../mesh/skin.js";
import { frameAt, placeOf } from "../recording/between.js";
import { TimeBar } from "./time_bar.js";
import { ViewSettings, cameraButtons } from "./view_settings.js";

/** Smaller values under the pointer are 0, in the unit that is shown. */
const LEAST_SHOWN = 5e-4;

export class Stage {
  element;
  #name;
  #recording;
  #view;
  #legend = new Legend();
  #skin = null;
  #count = 0;
  #isChosen = false;
  #isWhole = false;
  #note = html("p", { class: "quiet", hidden: true });
  settings;
  time;

  /**
   * Begins at the instant `at` [s], or the nearest of which there is a frame. `thresholds` of stress [Pa]; `onFrame(frame)` after another
   * one is shown, `onSettings()` after another field is.
   */
  constructor(name, recording, at, thresholds, { onFrame = () => {}, onSettings = () => {} } = {}) {
    this.#name = name;
    this.#recording = recording;
    this.onFrame = onFrame;
    this.onSettings = onSettings;
    this.settings = new ViewSettings([recording], thresholds, (isView) => this.#settingsChanged(isView));
    this.#view = new MeshView(`Mesh of ${name}, coloured`);
    this.#setBodies();
    this.#view.probe = (at) => this.#words(at);
    const { times, frames } = recording;
    this.time = new TimeBar(times, recording.endTime, () => this.#showFrame(), times.indexOf(frames[recording.frameNear(at)].time));
    const picture = button("PNG", async () => saveFile(`${name}.png`, await this.#view.picture()), { "aria-label": "Picture of the mesh as PNG" });
    const choose = (isWhole) => {
      this.#choose(isWhole);
      // Names stand where the new view has room.
      this.#showFrame();
    };
    this.#view.corner.append(...cameraButtons(choose), picture);
    this.element = html(
      "section",
      { class: "panel stage", "aria-label": "Mesh" },
      this.#legend.element,
      this.#view.element,
      this.time.element,
      html("div", { class: "stage-foot" }, this.settings.element, this.settings.details),
      this.#note,
    );
    this.#look();
    this.#settingsChanged();
  }

  /** Shows the frame that is waited for, if it has come. */
  grow() {
    if (this.time.isWaiting) this.#showFrame();
  }

  /** Takes the whole recording; where the slider has not been moved, goes to the instant `worst` [s], or to the end if that is not known. */
  finish(worst) {
    const { stride, frames } = this.#recording;
    this.time.setTimes(this.#recording.times);
    this.settings.refresh();
    // A body that was not in the first frame makes the picture anew.
    if (this.#recording.drawn.size !== this.#count) this.#setBodies();
    if (!this.#isChosen && !this.#view.isMoved) this.#look();
    this.#settingsChanged();
    this.#note.hidden = stride === 1;
    this.#note.textContent = `The recording is long: one field time in ${stride} is shown.`;
    if (this.time.isMoved) return;
    this.time.go(worst == null ? frames.length - 1 : this.#recording.frameNear(worst));
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.time.play();
  }

  #setBodies() {
    this.#count = this.#recording.drawn.size;
    this.#view.setBodies(this.#recording.drawn);
  }

  /** Looks as the reader asks: no later frame changes that. */
  #choose(isWhole) {
    this.#isChosen = true;
    this.#isWhole = isWhole;
    this.#look();
  }

  #look() {
    const { settings } = this;
    const isWhole = this.#isWhole;
    if (settings.isFlat) this.#view.lookAcross(settings.flatCamera(isWhole));
    else this.#view.lookAt(settings.camera(isWhole));
  }

  #settingsChanged(isView = false) {
    const { field, range, hidden, isLog, levels, levelNames, line, depth } = this.settings;
    this.#view.setLine(line, depth);
    for (const name of this.#recording.drawn.keys()) this.#view.setVisible(name, !hidden.has(name));
    if (field) {
      this.#view.setColours("values", range, { isLog, levels, levelNames });
      this.#legend.show(FIELDS[field], range, "values", { isLog, levels });
    }
    if (isView) this.#choose(this.#isWhole);
    this.onSettings();
    this.#showFrame();
  }

  #showFrame() {
    const { settings } = this;
    const { time } = this.time;
    this.time.isWaiting = !this.#recording.has(time);
    if (this.time.isWaiting) return;
    const frame = frameAt(this.#recording, placeOf(this.#recording, time), (name) => settings.stretchOf(name));
    this.#view.show(frame, (name, state) => settings.valuesOf(name, state), settings.cut);
    this.onFrame(frame);
  }

  /** Layer, depth, the shown field, stress and displacement at a place. */
  #words({ name, part, rest, of }) {
    const body = this.#recording.drawn.get(name);
    if (!rest || body?.role === "bone") return part ?? name;
    const depth = body === this.#recording.tissue && this.settings.line ? this.#depthOf(rest) : null;
    const fields = [...new Set([this.settings.field, "von_mises_pa", "displacement_m"])].filter(Boolean);
    const values = fields.map((field) => [FIELDS[field], of(field)]).filter(([, value]) => value != null);
    return [
      body.role === "projectile" ? name : part,
      depth != null && `${withUnit(depth * 1e3, "mm", 2)} below the nearest surface`,
      ...values.map(([{ label, unit, factor }, value]) => `${label.split(" (")[0]} ${withUnit(Math.abs(value * factor) < LEAST_SHOWN ? 0 : value * factor, unit, 3)}`),
    ].filter(Boolean).join(" · ");
  }

  #depthOf(rest) {
    this.#skin ??= new Skin(this.#recording.tissue, this.settings.line.centre);
    return this.#skin.depthOf(rest);
  }

  dispose() {
    this.time.stop();
    this.#view.dispose();
  }
}
