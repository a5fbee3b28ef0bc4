// A recording to look at: the picture, and below it what follows its time.

import { html } from "../dom.js";
import { nearestApproach } from "../plots/impact_line.js";
import { significantThresholds, worstOf } from "../summary/headline.js";
import { withheldLine } from "../summary/trust.js";
import { Stage } from "./stage.js";

/** The plots, which are drawn when the whole recording is there. */
const loadPlots = () => import("../plots/plots_of_run.js");

export { prepareRenderer } from "../mesh/renderer.js";

export class RunPanel {
  /** The picture; the plots come below it. */
  stage = html("div", { class: "stage-holder" });
  element = html("div");
  #recording;
  #name;
  #summary;
  #thresholds;
  #stage = null;
  #plots = null;
  #isLeft = false;

  constructor(name, recording, summary) {
    this.#recording = recording;
    this.#name = name;
    this.#summary = summary;
    this.#thresholds = summary ? significantThresholds(summary) : [];
  }

  /** Draws a frame that is there, while the others are on their way. */
  begin() {
    if (this.#stage || !this.#recording.frames.length) return;
    this.#stage = new Stage(this.#name, this.#recording, this.#worst() ?? 0, this.#thresholds, {
      onFrame: () => this.#plots?.show(this.#stage),
      onSettings: () => this.#plots?.setField(this.#stage.settings),
    });
    this.stage.replaceChildren(this.#mark(), this.#stage.element);
  }

  /** What stands above pictures and curves that are no results. */
  #mark() {
    return withheldLine([{ summary: this.#summary }]) ?? "";
  }

  /** Shows what has come since. */
  grow() {
    this.#stage?.grow();
  }

  /** Shows the whole recording. */
  async finish() {
    this.begin();
    if (!this.#stage) this.stage.replaceChildren(html("p", { class: "panel quiet" }, "Nothing was recorded in space, so there is no picture. Field times are set under “What is recorded” of the scene."));
    const { PlotsOfRun } = await loadPlots();
    if (this.#isLeft) return;
    this.#plots = new PlotsOfRun(this.#name, this.#recording, this.#summary, { hasPicture: Boolean(this.#stage), onSeek: (time) => this.#stage?.time.goToTime(time) });
    this.element.replaceChildren(this.#mark(), this.#plots.element);
    this.#stage?.finish(this.#worst());
  }

  /** The instant of the largest force [s]: that of the summary, else that of the recorded steps; without contact that at which the projectile is nearest. */
  #worst() {
    const said = worstOf(this.#summary);
    if (said != null) return said;
    const forces = this.#recording.frames.map((frame) => Math.max(0, ...(frame.contacts ?? []).map((c) => c.force)));
    const most = Math.max(...forces);
    return most > 0 ? this.#recording.frames[forces.indexOf(most)].time : nearestApproach(this.#recording)?.time ?? null;
  }

  dispose() {
    this.#isLeft = true;
    this.#stage?.dispose();
    this.#plots?.dispose();
  }
}
