// A recording to look at: the picture, and beside it what follows its time: contact pressure, depth profile and curves.

import { html } from "../dom.js";
import { timeUnit } from "../format.js";
import { FIELDS } from "../mesh/colours.js";
import { DepthProfile } from "../plots/depth_profile.js";
import { mainPair } from "../plots/main_pair.js";
import { PatchPanel } from "../plots/patch.js";
import { ContactSurface } from "../plots/pressure.js";
import { contactPlots, energyPlot } from "../plots/run_plots.js";
import { significantThresholds, worstOf } from "../summary/headline.js";
import { Stage } from "./stage.js";
import { forceWindow } from "./view_settings.js";

export class RunPanel {
  /** The picture; the plots come below it. */
  stage = html("div", { class: "stage-holder" });
  element = html("div", { class: "plots" });
  #recording;
  #name;
  #summary;
  #thresholds;
  #stage = null;
  #plots = [];
  #profile = null;
  #profileHolder = html("section", { class: "panel" });
  #surface = null;
  #patch = null;
  #isWhole = false;
  #shown = -1;

  constructor(name, recording, summary) {
    this.#recording = recording;
    this.#name = name;
    this.#summary = summary;
    this.#thresholds = summary ? significantThresholds(summary) : [];
  }

  /** Draws a frame that is there, while the others are on their way. */
  begin() {
    if (this.#stage || !this.#recording.frames.length) return;
    this.#stage = new Stage(this.#name, this.#recording, this.#worst() ?? 0, this.#thresholds, { onFrame: () => this.#showFrame(), onSettings: () => this.#settingsChanged() });
    this.stage.replaceChildren(this.#stage.element);
  }

  /** Shows what has come since. */
  grow() {
    this.#stage?.grow();
  }

  /** Shows the whole recording. */
  finish() {
    this.#isWhole = true;
    this.begin();
    if (!this.#stage) this.stage.replaceChildren(html("p", { class: "panel quiet" }, "Nothing was recorded in space, so there is no picture. Field times are set under “What is recorded” of the scene."));
    this.#addPatch();
    this.#addPlots();
    this.#stage?.finish(this.#worst());
  }

  /** The instant of the largest force [s]: that of the summary, else that of the recorded steps; null without contact. */
  #worst() {
    const said = worstOf(this.#summary);
    if (said != null) return said;
    const forces = this.#recording.frames.map((frame) => Math.max(0, ...(frame.contacts ?? []).map((c) => c.force)));
    const most = Math.max(...forces);
    return most > 0 ? this.#recording.frames[forces.indexOf(most)].time : null;
  }

  #addPatch() {
    this.#surface = new ContactSurface(this.#recording);
    const patches = this.#recording.frames.map((frame) => this.#surface.patch(frame, this.#contactsOf(frame))).filter(Boolean);
    if (!patches.length) return;
    const touching = ({ points, facets }) => (facets.length ? facets.flat().filter((p) => p.pressure > 0) : points);
    const extent = patches.flatMap(touching).reduce((most, p) => Math.max(most, Math.hypot(p.x, p.y)), 1e-4);
    const high = patches.map((patch) => patch.high).sort((a, b) => a - b);
    this.#patch = new PatchPanel(this.#name, 1.15 * extent, high[Math.floor(0.9 * (high.length - 1))] || 1);
  }

  #contactsOf(frame) {
    const pair = mainPair(this.#recording);
    return frame.contacts?.find((contacts) => contacts.pair === pair);
  }

  #settingsChanged() {
    if (!this.#isWhole || !this.#stage) return;
    const { field, line, range, levels } = this.#stage.settings;
    if (!field || !line) return;
    this.#shown = -1;
    const shown = FIELDS[field];
    this.#profile?.dispose();
    const marks = levels.map((value) => ({ value: value * shown.factor, label: `${value * shown.factor} ${shown.unit}` }));
    this.#profile = new DepthProfile(this.#name, this.#recording.tissue, line, shown, range[1] * shown.factor, marks);
    this.#profileHolder.replaceChildren(this.#profile.element);
  }

  #addPlots() {
    const recording = this.#recording;
    const unit = timeUnit(recording.endTime);
    const shared = {
      name: this.#name,
      group: `time of ${this.#name}`,
      onSeek: (x) => this.#stage?.time.goToTime(x / unit.factor),
    };
    const run = { label: this.#name, recording, window: forceWindow(this.#summary) };
    this.#plots = contactPlots([run], shared);
    if (recording.series.energyTimes.length > 1) this.#plots.splice(1, 0, energyPlot([run], shared));
    const panels = this.#plots.map((plot) => html("section", { class: "panel" }, plot.element));
    if (this.#stage && recording.tissue) panels.splice(2, 0, this.#profileHolder);
    if (this.#patch) panels.splice(2, 0, html("section", { class: "panel" }, this.#patch.element));
    this.element.replaceChildren(...panels);
  }

  /** What follows the time shows the nearest frame, as it was recorded. */
  #showFrame() {
    if (!this.#isWhole || !this.#stage || this.#stage.time.index === this.#shown) return;
    this.#shown = this.#stage.time.index;
    const frame = this.#recording.frames[this.#shown];
    const { field } = this.#stage.settings;
    const contacts = this.#contactsOf(frame);
    this.#patch?.show(this.#surface.patch(frame, contacts), contacts);
    const tissue = frame.bodies.get(this.#recording.tissue?.name);
    if (tissue?.fields[field]) this.#profile?.show(tissue, tissue.fields[field]);
    for (const plot of this.#plots) plot.mark(frame.time * timeUnit(this.#recording.endTime).factor);
  }

  dispose() {
    this.#stage?.dispose();
    this.#profile?.dispose();
    this.#plots.forEach((plot) => plot.dispose());
  }
}
