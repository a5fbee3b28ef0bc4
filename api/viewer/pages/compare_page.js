// Two runs side by side: the four numbers and their difference, pictures with one camera at equal times, and curves in one plot.

import { getJson } from "../api.js";
import { html, select } from "../dom.js";
import { moment, timeUnit, withUnit } from "../format.js";
import { FIELDS, Legend } from "../mesh/colours.js";
import { MeshView } from "../mesh/mesh_view.js";
import { contactPlots, energyPlot } from "../plots/run_plots.js";
import { frameAt, placeOf } from "../recording/between.js";
import { significantThresholds } from "../summary/headline.js";
import { withheldLine } from "../summary/trust.js";
import { numbersTable } from "./compare_numbers.js";
import { commonBodies, firstTouch, loadRun, readAll } from "./compare_runs.js";
import { TimeBar } from "../picture/time_bar.js";
import { ViewSettings } from "../picture/view_settings.js";

/** The end of an address where equal times are those since the first contact of each. */
const SINCE_CONTACT = "?since-contact";
const endOfAddress = () => (location.hash.endsWith(SINCE_CONTACT) ? SINCE_CONTACT : "");

export async function comparePage(first, second, isSinceContact) {
  const { jobs } = await getJson("/v1/jobs?limit=200");
  const recorded = jobs.filter((job) => job.links.recording && job.links.summary);
  const [a, b] = [first ?? recorded[1]?.id, second ?? recorded.find((job) => job.id !== first)?.id];
  const element = html("div", {}, html("div", { class: "title" }, html("h1", {}, "Two impacts, side by side")), chooser(recorded, a, b));
  if (!a || !b) {
    element.append(html("p", { class: "panel quiet" }, "Two recordings are needed."));
    return { title: "Compare", element };
  }
  const runs = await Promise.all([["A", a], ["B", b]].map(([label, id]) => loadRun(label, id)));
  // A choice makes no entry in the history: the page is the same.
  const onClock = (isSince) => history.replaceState(null, "", `#/compare/${a}/${b}${isSince ? SINCE_CONTACT : ""}`);
  const comparison = new Comparison(runs, isSinceContact, onClock);
  element.append(comparison.element);
  comparison.read();
  return { title: "Compare", element, leave: () => comparison.dispose() };
}

function chooser(jobs, a, b) {
  const options = jobs.map((job) => [job.id, `${job.name} · ${moment(job.created_at)}`]);
  return html(
    "div",
    { class: "choose panel" },
    select("A", options, a, (id) => (location.hash = `#/compare/${id}/${b}${endOfAddress()}`)),
    select("B", options, b, (id) => (location.hash = `#/compare/${a}/${id}${endOfAddress()}`)),
  );
}

const CLOCKS = [["simulated", "in simulated time"], ["contact", "since first contact of each"]];

class Comparison {
  element = html("div");
  #runs;
  #views = [];
  #legends = [];
  #clocks = [];
  #plots = [];
  #curves = html("div", { class: "plots pairs" });
  #time = null;
  #timeHolder = html("div");
  #clockHolder = html("div", { class: "settings-row" });
  #note = html("p", { class: "quiet", "aria-live": "polite" });
  #bar = html("progress", { max: 1, value: 0, "aria-label": "Reading the recordings" });
  #loading = html("p", { class: "quiet loading" }, "Reading the recordings ", this.#bar);
  #isSinceContact = false;
  #onClock;
  #isLeft = false;

  /** `isSinceContact` where each has one; `onClock(isSinceContact)` after the reader has chosen. */
  constructor(runs, isSinceContact, onClock) {
    this.#runs = runs;
    this.#onClock = onClock;
    if (isSinceContact && this.#canShift) this.#shift(true);
    this.element.append(numbersTable(runs), this.#loading, this.#curves);
  }

  /** Reads the recordings: the pictures come with a frame of each, the curves when all is there. */
  async read() {
    try {
      for (const run of this.#runs) run.recording = await run.opening;
      const times = this.#times;
      const onFirst = () => this.#runs.every(({ recording }) => recording.frames.length) && !this.#isLeft && this.#addSpace();
      const onProgress = (fraction) => {
        this.#bar.value = fraction;
        if (this.#time?.isWaiting && !this.#isLeft) this.#showFrame();
      };
      await readAll(this.#runs, times[Math.floor((times.length - 1) / 2)] ?? 0, { onFirst, onProgress });
      if (!this.#isLeft) this.#finish();
    } catch (error) {
      if (this.#isLeft) return;
      console.error(error);
      this.#loading.replaceWith(html("p", { class: "alert", role: "alert" }, error.message));
    }
  }

  /** All of both is there: what is looked for in all frames is looked for again, and the curves are drawn. */
  #finish() {
    this.#loading.remove();
    for (const run of this.#runs) run.contact ??= firstTouch(run.recording);
    this.#addPlots();
    if (!this.settings) return;
    this.#showClocks();
    this.settings.refresh();
    this.#setBodies();
    if (!this.#views.some((view) => view.isMoved)) this.#look();
    this.#time.setTimes(this.#times);
    this.#settingsChanged();
  }

  /** Times of the frames of both, by the clock of each [s]. */
  get #times() {
    return [...new Set(this.#runs.flatMap(({ recording, shift }) => recording.times.map((time) => time - shift)))].sort((a, b) => a - b);
  }

  get #unit() {
    return timeUnit(Math.max(...this.#runs.map(({ recording }) => recording.endTime)));
  }

  #addSpace() {
    const recordings = this.#runs.map((run) => run.recording);
    const thresholds = significantThresholds(this.#runs[0].summary);
    this.settings = new ViewSettings(recordings, thresholds, (isView) => this.#settingsChanged(isView));
    this.common = this.#withheld.length ? new Set() : commonBodies(this.#runs);
    const stages = this.#runs.map((run) => this.#addView(`${run.label}: ${run.job.name}`));
    if (this.common.size) stages.push(this.#addView("B − A, on the shape of A"));
    this.#setBodies();
    this.#views.forEach((view) => view.linkTo(this.#views));
    this.#showClocks();
    this.#loading.before(
      html("section", { class: "panel" }, withheldLine(this.#runs), html("div", { class: "side-by-side" }, stages), this.#timeHolder, this.#note,
        html("div", { class: "stage-foot" }, this.#clockHolder, this.settings.element, this.settings.details)),
    );
    this.#look();
    this.#setTimes();
    this.#settingsChanged();
  }

  /** Gives each view its bodies, unless it shows them already: those that are rigid come with the frames. */
  #setBodies() {
    const [{ recording: first }] = this.#runs;
    const bodies = [...this.#runs.map(({ recording }) => recording.drawn), new Map([...first.bodies].filter(([name]) => this.common.has(name)))];
    this.#views.forEach((view, i) => view.bodyCount !== bodies[i].size && view.setBodies(bodies[i]));
  }

  /** Whether each has a first contact. */
  get #canShift() {
    return this.#runs.every(({ contact }) => contact != null);
  }

  #shift(isSinceContact) {
    this.#isSinceContact = isSinceContact;
    for (const run of this.#runs) run.shift = isSinceContact ? run.contact : 0;
  }

  /** What equal times can be: since the contact of each only where each has one. */
  #showClocks() {
    const chosen = this.#isSinceContact ? "contact" : "simulated";
    this.#clockHolder.replaceChildren(select("Equal times are", this.#canShift ? CLOCKS : CLOCKS.slice(0, 1), chosen, (value) => this.#setClock(value === "contact")));
  }

  /** The runs whose numbers are withheld: a difference with them says nothing. */
  get #withheld() {
    return this.#runs.filter(({ summary }) => summary.withheld);
  }

  #addView(title) {
    const [view, legend, clock] = [new MeshView(title), new Legend(), html("output", { class: "time-output" })];
    this.#views.push(view);
    this.#legends.push(legend);
    this.#clocks.push(clock);
    return html("div", { class: "stage" }, html("h2", {}, title, " ", clock), legend.element, view.element);
  }

  /** Times of both from now on are since the first contact, or simulated ones; the slider and the curves begin anew. */
  #setClock(isSinceContact) {
    this.#shift(isSinceContact);
    this.#onClock(isSinceContact);
    if (this.#plots.length) this.#addPlots();
    this.#setTimes();
    this.#showFrame();
  }

  /** A slider over the times of both, at the middle of them. */
  #setTimes() {
    const times = this.#times;
    this.#time?.stop();
    this.#time = new TimeBar(times, Math.max(...this.#runs.map(({ recording }) => recording.endTime)), () => this.#showFrame(), Math.floor((times.length - 1) / 2));
    this.#timeHolder.replaceChildren(this.#time.element);
  }

  #look() {
    const { settings } = this;
    for (const view of this.#views) {
      view.setLine(settings.line, settings.depth);
      if (settings.isFlat) view.lookAcross(settings.flatCamera());
      else view.lookAt(settings.camera());
    }
  }

  #settingsChanged(isView = false) {
    const { field, range, hidden, isLog, levels, levelNames } = this.settings;
    const [a, b, difference] = this.#views;
    for (const view of this.#views) {
      for (const name of new Set(this.#runs.flatMap((run) => [...run.recording.drawn.keys()]))) view.setVisible(name, !hidden.has(name));
    }
    if (field) {
      [a, b].forEach((view) => view.setColours("values", range, { isLog, levels, levelNames }));
      this.#legends.slice(0, 2).forEach((legend) => legend.show(FIELDS[field], range, "values", { isLog, levels }));
      // Half of the range of the field on either side of nothing.
      const top = range[1] / 2;
      difference?.setColours("difference", [-top, top]);
      this.#legends[2]?.show({ ...FIELDS[field], label: `difference of ${FIELDS[field].label}` }, [-top, top], "difference");
    }
    if (isView) this.#look();
    this.#showFrame();
  }

  /** Shows both at the same time; a run that has no such time shows its nearest, and there is no difference then. */
  #showFrame() {
    if (!this.#time) return;
    const { time } = this.#time;
    const { settings } = this;
    const { factor, name } = this.#unit;
    const words = (seconds) => withUnit(seconds * factor, name);
    const owns = this.#runs.map(({ recording: { times }, shift }) => Math.min(Math.max(time + shift, times[0]), times.at(-1)));
    this.#time.isWaiting = this.#runs.map(({ recording }, i) => recording.has(owns[i])).includes(false);
    if (this.#time.isWaiting) return;
    const shown = this.#runs.map(({ recording, shift }) => {
      const [own, first, last] = [time + shift, recording.times[0], recording.times.at(-1)];
      const slack = 1e-9 * last;
      return { own, has: own >= first - slack && own <= last + slack, frame: frameAt(recording, placeOf(recording, own), (body) => settings.stretchOf(body)) };
    });
    shown.forEach(({ frame, own, has }, i) => {
      this.#views[i].show(frame, (body, state) => settings.valuesOf(body, state), settings.cut);
      this.#clocks[i].textContent = has ? words(own) : `${own > frame.time ? "ended" : "begins"} at ${words(frame.time)}`;
    });
    const isEqual = shown.every(({ has }) => has);
    this.#views[2]?.show(shown[0].frame, (body, state) => {
      const other = shown[1].frame.bodies.get(body)?.fields?.[settings.field];
      return isEqual && other && state.fields?.[settings.field] ? other.map((value, i) => value - state.fields[settings.field][i]) : null;
    }, settings.cut);
    if (this.#clocks[2]) this.#clocks[2].textContent = isEqual ? "" : "none at this time";
    this.#note.textContent = this.#noteOn(isEqual);
    for (const plot of this.#plots) plot.mark(time * factor);
  }

  #noteOn(isEqual) {
    if (this.#withheld.length) return "No difference is drawn with a run that is withheld: its picture and its curves are no results.";
    if (!this.common.size) return "The meshes are not the same, so there is no difference in space; the numbers and curves have one.";
    const clock = this.#isSinceContact ? "times since first contact" : "simulated times";
    return isEqual ? `The difference is at equal ${clock}, linear between the recorded frames.` : `One of the runs has no such time: differences are at equal ${clock} only.`;
  }

  #addPlots() {
    const { factor } = this.#unit;
    const seek = (x) => {
      const [{ recording, shift }] = this.#runs;
      this.#time?.goToTime(recording.frames[recording.frameNear(x / factor + shift)].time - shift);
    };
    const shared = { name: "comparison", group: "time of both", onSeek: seek, time: this.#isSinceContact ? "time since first contact" : "time" };
    this.#plots.forEach((plot) => plot.dispose());
    this.#plots = contactPlots(this.#runs, shared);
    this.#plots.splice(1, 0, energyPlot(this.#runs, shared));
    this.#curves.replaceChildren(withheldLine(this.#runs) ?? "", ...this.#plots.map((plot) => html("section", { class: "panel" }, plot.element)));
  }

  dispose() {
    this.#isLeft = true;
    this.#time?.stop();
    this.#views.forEach((view) => view.dispose());
    this.#plots.forEach((plot) => plot.dispose());
  }
}
