// What follows the time of a picture: contact pressure, depth profile and curves.

import { html } from "../dom.js";
import { timeUnit } from "../format.js";
import { FIELDS } from "../mesh/colours.js";
import { forceWindow } from "../picture/view_settings.js";
import { DepthProfile } from "./depth_profile.js";
import { mainPair } from "./main_pair.js";
import { PatchPanel } from "./patch.js";
import { ContactSurface, highPressure } from "./pressure.js";
import { contactPlots, energyPlot } from "./run_plots.js";

export class PlotsOfRun {
  element = html("div", { class: "plots" });
  #recording;
  #name;
  #plots = [];
  #profile = null;
  #profileHolder = html("section", { class: "panel" });
  #surface;
  #patch = null;
  #shown = -1;

  /** Of a whole recording with its `summary` or null; `onSeek(time)` [s] where a reader points at a time of a curve. */
  constructor(name, recording, summary, { hasPicture, onSeek }) {
    this.#name = name;
    this.#recording = recording;
    this.#surface = new ContactSurface(recording);
    this.#addPatch();
    this.#addPlots(forceWindow(summary), hasPicture, onSeek);
  }

  #addPatch() {
    const patches = this.#recording.frames.map((frame) => this.#surface.patch(frame, this.#contactsOf(frame))).filter(Boolean);
    if (!patches.length) return;
    const touching = ({ points, facets }) => (facets.length ? facets.flat().filter((p) => p.pressure > 0) : points);
    const extent = patches.flatMap(touching).reduce((most, p) => Math.max(most, Math.hypot(p.x, p.y)), 1e-4);
    this.#patch = new PatchPanel(this.#name, 1.15 * extent, highPressure(patches.flatMap(({ nodes }) => nodes)) || 1);
  }

  #contactsOf(frame) {
    const pair = mainPair(this.#recording);
    return frame.contacts?.find((contacts) => contacts.pair === pair);
  }

  #addPlots(window, hasPicture, onSeek) {
    const recording = this.#recording;
    const unit = timeUnit(recording.endTime);
    const shared = { name: this.#name, group: `time of ${this.#name}`, onSeek: (x) => onSeek(x / unit.factor) };
    const run = { label: this.#name, recording, window };
    this.#plots = contactPlots([run], shared);
    if (recording.series.energyTimes.length > 1) this.#plots.splice(1, 0, energyPlot([run], shared));
    const panels = this.#plots.map((plot) => html("section", { class: "panel" }, plot.element));
    if (hasPicture && recording.tissue) panels.splice(2, 0, this.#profileHolder);
    if (this.#patch) panels.splice(2, 0, html("section", { class: "panel" }, this.#patch.element));
    this.element.replaceChildren(...panels);
  }

  /** The depth profile is of the field that the picture shows, in its range. */
  setField({ field, line, range, levels }) {
    if (!field || !line) return;
    this.#shown = -1;
    const shown = FIELDS[field];
    this.#profile?.dispose();
    const marks = levels.map((value) => ({ value: value * shown.factor, label: `${value * shown.factor} ${shown.unit}` }));
    this.#profile = new DepthProfile(this.#name, this.#recording.tissue, line, shown, range[1] * shown.factor, marks);
    this.#profileHolder.replaceChildren(this.#profile.element);
  }

  /** Shows the nearest frame to the time of the picture, as it was recorded. */
  show({ time, settings }) {
    if (time.index === this.#shown) return;
    this.#shown = time.index;
    const frame = this.#recording.frames[this.#shown];
    const contacts = this.#contactsOf(frame);
    this.#patch?.show(this.#surface.patch(frame, contacts), contacts);
    const tissue = frame.bodies.get(this.#recording.tissue?.name);
    if (tissue?.fields[settings.field]) this.#profile?.show(tissue, tissue.fields[settings.field]);
    for (const plot of this.#plots) plot.mark(frame.time * timeUnit(this.#recording.endTime).factor);
  }

  dispose() {
    this.#profile?.dispose();
    this.#plots.forEach((plot) => plot.dispose());
  }
}
