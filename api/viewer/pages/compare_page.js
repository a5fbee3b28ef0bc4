// Two runs side by side: the four numbers and their difference, pictures with one camera at equal times, and curves in one plot.

import { getJson } from "../api.js";
import { html, select } from "../dom.js";
import { moment, timeUnit, withUnit } from "../format.js";
import { FIELDS, Legend } from "../mesh/colours.js";
import { MeshView } from "../mesh/mesh_view.js";
import { contactPlots, energyPlot } from "../plots/run_plots.js";
import { frameAt, placeOf } from "../recording/between.js";
import { Recording } from "../recording/recording.js";
import { mainImpact, resultsOf, significantThresholds } from "../summary/headline.js";
import { numbersTable } from "./compare_numbers.js";
import { TimeBar } from "../picture/time_bar.js";
import { ViewSettings, forceWindow } from "../picture/view_settings.js";

export async function comparePage(first, second) {
  const { jobs } = await getJson("/v1/jobs?limit=200");
  const recorded = jobs.filter((job) => job.links.recording && job.links.summary);
  const [a, b] = [first ?? recorded[1]?.id, second ?? recorded.find((job) => job.id !== first)?.id];
  const element = html("div", {}, html("div", { class: "title" }, html("h1", {}, "Two impacts, side by side")), chooser(recorded, a, b));
  if (!a || !b) {
    element.append(html("p", { class: "panel quiet" }, "Two recordings are needed."));
    return { title: "Compare", element };
  }
  const runs = await Promise.all([["A", a], ["B", b]].map(([label, id]) => loadRun(label, id)));
  const comparison = new Comparison(runs);
  element.append(comparison.element);
  return { title: "Compare", element, leave: () => comparison.dispose() };
}

function chooser(jobs, a, b) {
  const options = jobs.map((job) => [job.id, `${job.name} · ${moment(job.created_at)}`]);
  return html(
    "div",
    { class: "choose panel" },
    select("A", options, a, (id) => (location.hash = `#/compare/${id}/${b}`)),
    select("B", options, b, (id) => (location.hash = `#/compare/${a}/${id}`)),
  );
}

async function loadRun(label, id) {
  const job = await getJson(`/v1/jobs/${id}`);
  if (!job.links.summary || !job.links.recording) throw new Error(`${job.name} has no recording with numbers, so there is nothing to compare.`);
  const [summary, recording] = await Promise.all([getJson(job.links.summary), Recording.open(job.links.recording).then((opened) => opened.read())]);
  return { label, job, summary, recording, window: forceWindow(summary), contact: firstContact(summary, recording), shift: 0 };
}

/** Simulated time at which a run's contact with the tissue begins [s]; null without contact. */
function firstContact(summary, recording) {
  const span = mainImpact(resultsOf(summary))?.contact_span_s;
  if (span) return span[0];
  const touching = recording.frames.find((frame) => frame.contacts?.some(({ node }) => node.length));
  return touching ? touching.time : null;
}

/** Bodies of both whose nodes can be compared one by one. */
function commonBodies([a, b]) {
  const names = [...a.recording.bodies.values()].filter(({ name, cells }) => {
    const other = b.recording.bodies.get(name);
    return cells && other?.cells && cells.equals(other.cells);
  });
  return new Set(names.map(({ name }) => name));
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
  #note = html("p", { class: "quiet", "aria-live": "polite" });
  #isSinceContact = false;

  constructor(runs) {
    this.#runs = runs;
    this.element.append(numbersTable(runs));
    if (runs.every(({ recording }) => recording.frames.length)) this.#addSpace();
    this.element.append(this.#curves);
    this.#setClock(false);
  }

  get #unit() {
    return timeUnit(Math.max(...this.#runs.map(({ recording }) => recording.endTime)));
  }

  #addSpace() {
    const recordings = this.#runs.map((run) => run.recording);
    const thresholds = significantThresholds(this.#runs[0].summary);
    this.settings = new ViewSettings(recordings, thresholds, (isView) => this.#settingsChanged(isView));
    this.common = commonBodies(this.#runs);
    const stages = this.#runs.map((run) => this.#addView(`${run.label}: ${run.job.name}`, run.recording.drawn));
    if (this.common.size) {
      const bodies = [...recordings[0].bodies].filter(([name]) => this.common.has(name));
      stages.push(this.#addView("B − A, on the shape of A", bodies));
    }
    this.#views.forEach((view) => view.linkTo(this.#views));
    const canShift = this.#runs.every(({ contact }) => contact != null);
    const clock = select("Equal times are", canShift ? CLOCKS : CLOCKS.slice(0, 1), "simulated", (value) => this.#setClock(value === "contact"));
    this.element.append(
      html("section", { class: "panel" }, html("div", { class: "side-by-side" }, stages), this.#timeHolder, this.#note,
        html("div", { class: "stage-foot" }, html("div", { class: "settings-row" }, clock), this.settings.element, this.settings.details)),
    );
    this.#look();
    this.#settingsChanged();
  }

  #addView(title, bodies) {
    const [view, legend, clock] = [new MeshView(title), new Legend(), html("output", { class: "time-output" })];
    view.setBodies(bodies);
    this.#views.push(view);
    this.#legends.push(legend);
    this.#clocks.push(clock);
    return html("div", { class: "stage" }, html("h2", {}, title, " ", clock), legend.element, view.element);
  }

  /** Times of both from now on are since the first contact, or simulated ones; the slider and the curves begin anew. */
  #setClock(isSinceContact) {
    this.#isSinceContact = isSinceContact;
    for (const run of this.#runs) run.shift = isSinceContact ? run.contact : 0;
    this.#addPlots();
    if (!this.settings) return;
    const times = new Set(this.#runs.flatMap(({ recording, shift }) => recording.frames.map((frame) => frame.time - shift)));
    this.#time?.stop();
    this.#time = new TimeBar([...times].sort((a, b) => a - b), Math.max(...this.#runs.map(({ recording }) => recording.endTime)), () => this.#showFrame());
    this.#timeHolder.replaceChildren(this.#time.element);
    this.#time.go(Math.floor((times.size - 1) / 2));
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
    const { field, map, range, hidden, isLog, levels } = this.settings;
    const [a, b, difference] = this.#views;
    for (const view of this.#views) {
      for (const name of new Set(this.#runs.flatMap((run) => [...run.recording.drawn.keys()]))) view.setVisible(name, !hidden.has(name));
    }
    if (field) {
      [a, b].forEach((view) => view.setColours(map, range, { isLog, levels }));
      this.#legends.slice(0, 2).forEach((legend) => legend.show(FIELDS[field], range, map, { isLog, levels }));
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
    const shown = this.#runs.map(({ recording, shift }) => {
      const [own, first, last] = [time + shift, recording.frames[0].time, recording.frames.at(-1).time];
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
    this.#curves.replaceChildren(...this.#plots.map((plot) => html("section", { class: "panel" }, plot.element)));
  }

  dispose() {
    this.#time?.stop();
    this.#views.forEach((view) => view.dispose());
    this.#plots.forEach((plot) => plot.dispose());
  }
}
