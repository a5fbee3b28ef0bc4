// Two runs side by side: the four numbers and their difference, meshes with one camera, and curves in one plot.

import { getJson } from "../api.js";
import { html, select, table } from "../dom.js";
import { change, number, timeUnit } from "../format.js";
import { FIELDS, Legend } from "../mesh/colours.js";
import { MeshView } from "../mesh/mesh_view.js";
import { contactPlots, energyPlot } from "../plots/run_plots.js";
import { Recording } from "../recording/recording.js";
import { bracketed, errorWords, hasError, headline, isMiss } from "../summary/headline.js";
import { stoppedAt } from "../summary/trust.js";
import { TimeBar } from "./time_bar.js";
import { ViewSettings, forceWindow } from "./view_settings.js";

export async function comparePage(first, second) {
  const { jobs } = await getJson("/v1/jobs?limit=200");
  const recorded = jobs.filter((job) => job.links.recording && job.links.summary);
  const [a, b] = [first ?? recorded[1]?.id, second ?? recorded.find((job) => job.id !== first)?.id];
  const element = html("div", {}, html("div", { class: "title" }, html("h1", {}, "Two impacts, side by side")), chooser(recorded, a, b));
  if (recorded.length < 2 || !a || !b) {
    element.append(html("p", { class: "panel quiet" }, "Two recordings are needed."));
    return { title: "Compare", element };
  }
  const runs = await Promise.all([["A", a], ["B", b]].map(([label, id]) => loadRun(label, id)));
  const comparison = new Comparison(runs);
  element.append(comparison.element);
  return { title: "Compare", element, leave: () => comparison.dispose() };
}

function chooser(jobs, a, b) {
  const options = jobs.map((job) => [job.id, `${job.name} · ${new Date(job.created_at).toLocaleTimeString()}`]);
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
  const [summary, recording] = await Promise.all([getJson(job.links.summary), Recording.open(job.links.recording)]);
  return { label, job, summary, recording, window: forceWindow(summary) };
}

/** The four numbers of both, and B − A; a difference below the sum of the errors says nothing. */
function numbersTable([a, b]) {
  const [left, right] = [headline(a.summary), headline(b.summary)];
  const rows = left.map((p, i) => {
    const q = right[i];
    // Depths above different thresholds are different numbers.
    const isSame = p.label === q.label;
    const name = `${isSame ? p.label : `${p.label}; ${q.label}`} [${p.unit}]`;
    const isComparable = isSame && p.quantity && q.quantity && [a, b].every(({ summary }) => !summary.withheld && !isMiss(summary));
    return [name, numberCell(a.summary, p), numberCell(b.summary, q), isComparable ? differenceCell(p.quantity, q.quantity) : "–"];
  });
  return html("section", { class: "panel" }, table("The four numbers with their errors", ["", runTitle(a), runTitle(b), "B − A"], rows));
}

function runTitle({ label, job, summary }) {
  const stopped = stoppedAt(summary);
  return `${label}: ${job.name}${stopped ? ` (${summary.ending} at ${stopped})` : ""}`;
}

function numberCell(summary, { quantity }) {
  if (!quantity) return "–";
  if (isMiss(summary)) return "nothing touched";
  return summary.withheld ? "withheld" : `${bracketed(quantity)} ${hasError(quantity) ? errorWords(quantity, "") : `(error ${errorWords(quantity, "")})`}`;
}

function differenceCell(p, q) {
  const difference = q.value - p.value;
  const fraction = p.value === 0 ? "" : ` (${change((100 * difference) / p.value, 100, 2)} %)`;
  return html("span", {}, `${change(difference, Math.max(Math.abs(p.value), Math.abs(q.value)))}${fraction} `, verdict(p, q, difference));
}

function verdict(p, q, difference) {
  if (!hasError(p) || !hasError(q)) return html("span", { class: "badge" }, "errors unknown");
  const isClear = Math.abs(difference) > p.error.total + q.error.total;
  return html("span", { class: isClear ? "badge good" : "badge warn" }, isClear ? "beyond the errors" : "within the errors");
}

/** Bodies of both whose nodes can be compared one by one. */
function commonBodies([a, b]) {
  const names = [...a.recording.bodies.values()].filter(({ name, cells }) => {
    const other = b.recording.bodies.get(name);
    return cells && other?.cells && cells.equals(other.cells);
  });
  return new Set(names.map(({ name }) => name));
}

class Comparison {
  element = html("div");
  #runs;
  #views = [];
  #legends = [];
  #plots = [];

  constructor(runs) {
    this.#runs = runs;
    this.element.append(numbersTable(runs));
    if (runs.every(({ recording }) => recording.frames.length)) this.#addSpace();
    this.#addPlots();
    this.#time?.go(Math.floor(this.#times.length / 2));
  }

  #time = null;

  #addSpace() {
    const recordings = this.#runs.map((run) => run.recording);
    this.settings = new ViewSettings(recordings, () => this.#settingsChanged());
    this.common = commonBodies(this.#runs);
    this.#times = recordings[0].frames.map((frame) => frame.time);
    const stages = this.#runs.map((run) => this.#addView(`${run.label}: ${run.job.name}`, run.recording.bodies));
    if (this.common.size) {
      const bodies = [...recordings[0].bodies].filter(([name]) => this.common.has(name));
      stages.push(this.#addView("B − A, on the shape of A", bodies));
    }
    this.#views.forEach((view) => view.linkTo(this.#views));
    this.#time = new TimeBar(this.#times, recordings[0].endTime, () => this.#showFrame());
    const note = this.common.size ? null : html("p", { class: "quiet" }, "The meshes are not the same, so there is no difference in space; the numbers and curves have one.");
    this.element.append(
      html("section", { class: "panel" }, this.settings.element),
      html("section", { class: "panel" }, html("div", { class: "side-by-side" }, stages), note, this.#time.element),
    );
    const { centre, radius, direction } = this.settings.camera();
    this.#views.forEach((view) => view.lookAt(centre, radius, direction));
    this.#settingsChanged();
  }

  #times = [];

  #addView(title, bodies) {
    const [view, legend] = [new MeshView(title), new Legend()];
    view.setBodies(bodies);
    this.#views.push(view);
    this.#legends.push(legend);
    return html("div", { class: "stage" }, html("h3", {}, title), legend.element, view.element);
  }

  #settingsChanged() {
    const { field, map, range, hidden } = this.settings;
    const [a, b, difference] = this.#views;
    for (const view of this.#views) {
      for (const name of new Set(this.#runs.flatMap((run) => [...run.recording.bodies.keys()]))) view.setVisible(name, !hidden.has(name));
    }
    if (field) {
      [a, b].forEach((view) => view.setColours(map, range));
      this.#legends.slice(0, 2).forEach((legend) => legend.show(FIELDS[field], range, map));
      // Half of the range of the field on either side of nothing.
      const top = (range[1] - range[0]) / 2;
      difference?.setColours("difference", [-top, top]);
      this.#legends[2]?.show({ ...FIELDS[field], label: `difference of ${FIELDS[field].label}` }, [-top, top], "difference");
    }
    this.#showFrame();
  }

  #showFrame() {
    if (!this.#time) return;
    const time = this.#times[this.#time.index];
    const frames = this.#runs.map(({ recording }) => recording.frames[recording.frameNear(time)]);
    const { field, cut } = this.settings;
    frames.forEach((frame, i) => this.#views[i].show(frame, (_, state) => state.fields?.[field] ?? null, cut));
    this.#views[2]?.show(frames[0], (name, state) => {
      const other = frames[1].bodies.get(name)?.fields?.[field];
      return other && state.fields?.[field] ? other.map((value, i) => value - state.fields[field][i]) : null;
    }, cut);
    for (const plot of this.#plots) plot.mark(time * timeUnit(this.#runs[0].recording.endTime).factor);
  }

  #addPlots() {
    const unit = timeUnit(Math.max(...this.#runs.map(({ recording }) => recording.endTime)));
    const nearest = (x) => this.#runs[0].recording.frameNear(x / unit.factor);
    const shared = { name: "comparison", group: "time of both", onSeek: (x) => this.#time?.go(nearest(x)) };
    this.#plots = contactPlots(this.#runs, shared);
    this.#plots.splice(1, 0, energyPlot(this.#runs, shared));
    this.element.append(html("div", { class: "plots pairs" }, this.#plots.map((plot) => html("section", { class: "panel" }, plot.element))));
  }

  dispose() {
    this.#time?.stop();
    this.#views.forEach((view) => view.dispose());
    this.#plots.forEach((plot) => plot.dispose());
  }
}
