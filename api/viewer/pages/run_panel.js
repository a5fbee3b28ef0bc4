// A recording to look at: mesh with colours, time, patch, depth profile and curves, all at the same time.

import { button, html, saveFile } from "../dom.js";
import { timeUnit } from "../format.js";
import { FIELDS, Legend } from "../mesh/colours.js";
import { MeshView } from "../mesh/mesh_view.js";
import { DepthProfile } from "../plots/depth_profile.js";
import { PatchPanel, flatPatch } from "../plots/patch.js";
import { contactPlots, energyPlot, mainPair } from "../plots/run_plots.js";
import { resultsOf } from "../summary/headline.js";
import { TimeBar } from "./time_bar.js";
import { ViewSettings, forceWindow, resetButton } from "./view_settings.js";

export class RunPanel {
  element;
  #recording;
  #name;
  #plots = [];
  #view = null;
  #profile = null;

  constructor(name, recording, summary) {
    this.#recording = recording;
    this.#name = name;
    this.element = html("div");
    if (recording.frames.length) this.#addSpace(summary);
    else this.element.append(html("p", { class: "panel quiet" }, "No field was asked for, so there is no mesh to show (record.fields, record.field_interval_s)."));
    this.#addPlots(summary);
    this.#time?.go(this.#firstFrame());
  }

  #time = null;
  #profileHolder = html("section", { class: "panel" });

  /** The frame with the hardest contact says most. */
  #firstFrame() {
    const forces = this.#recording.frames.map((frame) => Math.max(0, ...(frame.contacts ?? []).map((c) => c.force)));
    return Math.max(...forces) > 0 ? forces.indexOf(Math.max(...forces)) : this.#recording.frames.length - 1;
  }

  #addSpace(summary) {
    const recording = this.#recording;
    this.settings = new ViewSettings([recording], () => this.#settingsChanged());
    this.#view = new MeshView(`Mesh of ${this.#name}, coloured`);
    this.#view.setBodies(recording.bodies);
    this.legend = new Legend();
    this.#time = new TimeBar(recording.frames.map((f) => f.time), recording.endTime, () => this.#showFrame());
    const picture = button("PNG", async () => saveFile(`${this.#name}.png`, await this.#view.picture()), { "aria-label": "Picture of the mesh as PNG" });
    const reset = resetButton(() => this.#lookAtAll());
    const stage = html(
      "section",
      { class: "panel stage", "aria-label": "Mesh" },
      html("div", { class: "stage-head" }, this.legend.element, html("div", { class: "tools" }, reset, picture)),
      this.#view.element,
      this.#time.element,
      recording.stride > 1 && html("p", { class: "quiet" }, `The recording is long: every ${recording.stride}th field time is shown.`),
    );
    const side = html("div", { class: "side" }, html("section", { class: "panel" }, this.settings.element), this.#sidePanels(summary));
    this.element.append(html("div", { class: "space" }, stage, side));
    this.#lookAtAll();
    this.#settingsChanged();
  }

  #sidePanels(summary) {
    const panels = [];
    const patches = this.#recording.frames.map((frame) => flatPatch(this.#contactsOf(frame))).filter(Boolean);
    if (patches.length) {
      const extent = Math.max(1e-4, ...patches.flatMap((patch) => patch.points.map((p) => Math.hypot(p.x, p.y))));
      this.patch = new PatchPanel(this.#name, extent);
      panels.push(html("section", { class: "panel" }, this.patch.element));
    }
    this.thresholds = summary ? (resultsOf(summary).tissue?.significant_stress ?? []).map((s) => s.threshold_pa) : [];
    return panels;
  }

  #contactsOf(frame) {
    const pair = mainPair(this.#recording);
    return frame.contacts?.find((contacts) => contacts.pair === pair);
  }

  #lookAtAll() {
    const { centre, radius, direction } = this.settings.camera();
    this.#view.lookAt(centre, radius, direction);
  }

  #settingsChanged() {
    const { field, map, range, hidden, line } = this.settings;
    for (const name of this.#recording.bodies.keys()) this.#view.setVisible(name, !hidden.has(name));
    if (field) {
      this.#view.setColours(map, range);
      this.legend.show(FIELDS[field], range, map);
      if (line) this.#newProfile(FIELDS[field], field, range);
    }
    this.#showFrame();
  }

  #newProfile(shown, field, range) {
    this.#profile?.dispose();
    const levels = field === "von_mises_pa" ? this.thresholds.map((pa) => ({ value: pa * shown.factor, label: `${pa / 1e3} kPa` })) : [];
    this.#profile = new DepthProfile(this.#name, this.#recording.tissue, this.settings.line, shown, range[1] * shown.factor, levels);
    this.#profileHolder.replaceChildren(this.#profile.element);
  }

  #addPlots(summary) {
    const recording = this.#recording;
    const unit = timeUnit(recording.endTime);
    const shared = {
      name: this.#name,
      group: `time of ${this.#name}`,
      onSeek: (x) => this.#time?.go(recording.frameNear(x / unit.factor)),
    };
    const run = { label: this.#name, recording, window: forceWindow(summary) };
    this.#plots = contactPlots([run], shared);
    if (recording.series.energyTimes.length > 1) this.#plots.splice(1, 0, energyPlot([run], shared));
    const panels = this.#plots.map((plot) => html("section", { class: "panel" }, plot.element));
    if (this.#profile) panels.splice(2, 0, this.#profileHolder);
    this.element.append(html("div", { class: "plots" }, panels));
  }

  #showFrame() {
    if (!this.#time) return;
    const frame = this.#recording.frames[this.#time.index];
    const { field } = this.settings;
    const contacts = this.#contactsOf(frame);
    const outline = flatPatch(contacts)?.hull.map((p) => p.position) ?? [];
    this.#view.show(frame, (_, state) => state.fields?.[field] ?? null, this.settings.cut, outline);
    this.patch?.show(contacts);
    const tissue = frame.bodies.get(this.#recording.tissue?.name);
    if (tissue && field) this.#profile?.show(tissue, tissue.fields[field]);
    for (const plot of this.#plots) plot.mark(frame.time * timeUnit(this.#recording.endTime).factor);
  }

  dispose() {
    this.#time?.stop();
    this.#view?.dispose();
    this.#profile?.dispose();
    this.#plots.forEach((plot) => plot.dispose());
  }
}
