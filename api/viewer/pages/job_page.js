// One job: its progress while it runs, then its four numbers, its mesh and its plots.

import { address, followEvents, getJson, request } from "../api.js";
import { button, html, saveFile } from "../dom.js";
import { bytes } from "../format.js";
import { Recording } from "../recording/recording.js";
import { headlineCards } from "../summary/cards.js";
import { worstOf } from "../summary/headline.js";
import { allNumbers } from "../summary/every_number.js";
import { injuryCriteria } from "../summary/criteria.js";
import { layerSentences } from "../summary/layers.js";
import { trustPanel } from "../summary/trust.js";
import { concerns, warningLine } from "../summary/warnings.js";
import { impactLine } from "../plots/impact_line.js";
import { layoutOf } from "../recording/layout.js";
import { addressOf, askedIn, titleOf } from "./ask_address.js";
import { pageOfQuestion } from "./asked.js";
import { ProgressPanel } from "./progress.js";
import { stateBadge } from "./state_badge.js";

/** The picture, which is much to load: meanwhile numbers are shown and the recording is opened. */
async function loadPanel() {
  const panel = await import("../picture/run_panel.js");
  panel.prepareRenderer();
  return panel;
}

const FINAL = ["succeeded", "failed", "cancelled"];

/** The page of a job, as the service describes it. */
export function jobPage(job) {
  const page = new JobPage(job);
  page.start();
  return { title: titleOf(page.job.name), element: page.element, leave: () => page.leave() };
}

class JobPage {
  #ending = new AbortController();
  #state = html("span");
  #tools = html("div", { class: "tools" });
  #body = html("div");
  #panel = null;
  /** The question of the page *Ask* that the job answers, and the address of its curve; null for other jobs. */
  #asked = null;
  #curve = null;

  constructor(job) {
    this.job = job;
    this.element = html("div", {}, html("div", { class: "title" }, html("h1", {}, titleOf(job.name), " ", this.#state), this.#tools), this.#body);
    this.#showTools();
  }

  start() {
    const show = () => (FINAL.includes(this.job.state) ? this.#showResults() : this.#follow());
    this.#readQuestion();
    show().catch((error) => this.#say(error));
  }

  leave() {
    this.#ending.abort();
    this.#panel?.dispose();
  }

  #say(error) {
    if (this.#ending.signal.aborted) return;
    console.error(error);
    this.#body.append(html("p", { class: "alert", role: "alert" }, error.message));
  }

  /** What can be done with the job: the scene is in its recording, and questions, studies and what was cancelled early have none. */
  #showTools() {
    const { id, links } = this.job;
    const link = (words, address) => html("a", { class: "button", href: address }, words);
    const page = pageOfQuestion(this.job);
    const tools = [
      links.recording && link("Change and run again", `#/new/${id}`),
      links.recording && links.summary && link("Compare", `#/compare/${id}`),
      links.recording && link("What if?", `#/what-if/${id}`),
      this.#curve && link("Show the curve", this.#curve),
      page && page !== this.#curve && link("Ask further", page),
      button("Delete", () => this.#delete().catch((error) => this.#say(error)), { class: "danger" }),
    ];
    this.#tools.replaceChildren(...tools.filter(Boolean));
  }

  /** Reads from the name of the job what was asked. The address of its curve is the page on which this tab asked it, or else that of the name. */
  #readQuestion() {
    this.#asked = askedIn(this.job.name);
    if (!this.#asked) return;
    const page = pageOfQuestion(this.job);
    this.#curve = page?.startsWith("#/ask?") ? page : addressOf(this.#asked, [this.job.id]);
    this.#showTools();
  }

  async #delete() {
    if (!confirm(`Delete ${titleOf(this.job.name)} and its recording? This cannot be undone.`)) return;
    await request(`/v1/jobs/${this.job.id}`, { method: "DELETE" });
    location.hash = "#/";
  }

  /** Progress until the job has ended. */
  async #follow() {
    const { WhatIfAnswer } = await import("./what_if_answer.js");
    const progress = new ProgressPanel(this.job, () => this.#peek());
    this.#body.replaceChildren(progress.element);
    this.#state.replaceChildren(stateBadge(this.job));
    const answer = new WhatIfAnswer(undefined, null, this.#asked);
    await followEvents(`/v1/jobs/${this.job.id}/events`, (event) => {
      progress.take(event);
      answer.take(event);
      if (event.event === "case" && !answer.element.parentElement) this.#body.append(html("section", { class: "panel" }, answer.element));
      if (event.data.state) this.#state.replaceChildren(stateBadge(event.data));
    }, this.#ending.signal);
    if (this.#ending.signal.aborted) return;
    this.job = await getJson(`/v1/jobs/${this.job.id}`);
    await this.#showResults();
  }

  /** A look at what is recorded of a job that still runs; false while that is nothing. */
  async #peek() {
    const { status } = await request(`/v1/jobs/${this.job.id}/recording?if_any=true`, { method: "HEAD" });
    if (status === 204) return false;
    const [recording, { RunPanel }] = await Promise.all([Recording.open(`/v1/jobs/${this.job.id}/recording`), loadPanel()]);
    await recording.read();
    this.#panel?.dispose();
    this.#panel = new RunPanel(this.job.name, recording, recording.latestSummary);
    this.#look.replaceChildren(html("p", { class: "quiet" }, "A look at the recording so far; the job goes on."), this.#panel.stage, this.#panel.element);
    this.#body.append(this.#look);
    await this.#panel.finish();
    return true;
  }

  #look = html("div");

  async #showResults() {
    const { job } = this;
    this.#panel?.dispose();
    this.#showTools();
    this.#body.replaceChildren();
    const opening = job.recording && Recording.open(job.links.recording);
    // What goes wrong there is said where it is waited for.
    opening?.catch(() => {});
    this.#state.replaceChildren(stateBadge(job));
    const summary = job.links.summary ? await getJson(job.links.summary) : null;
    const isRun = summary?.gates && summary?.error_bars;
    if (job.failure && !isRun) this.#body.append(failurePanel(job.failure));
    if (isRun) await this.#showRun(summary, opening);
    else if (summary?.cases) await this.#showAnswer(summary);
    else if (summary) this.#body.append((await import("./study_results.js")).studyResults(job.name, summary));
    if (opening && !isRun) await this.#showRecording(opening, html("div"), null);
  }

  /** One screen that answers: the picture, the four numbers, a sentence for each layer, what to know. Below it the rest. */
  async #showRun(summary, opening) {
    const { job } = this;
    const trust = trustPanel(summary, concerns(summary));
    const open = () => {
      trust.open = true;
      trust.scrollIntoView({ behavior: "smooth" });
    };
    const layers = html("div", {}, layerSentences(summary) ?? "");
    const picture = html("div", { class: "stage-holder" });
    const finer = job.links.recording && !job.failure && concerns(summary).some(({ isMeshed }) => isMeshed);
    const remedy = finer && html("a", { class: "button", href: `#/new/${job.id}?accuracy` }, "Run it again, refined");
    const answer = html("div", { class: "answer" }, html("div", {}, headlineCards(summary)), layers, warningLine(summary, open, remedy || null));
    const rest = html("div", { class: "rest" });
    this.#body.append(
      html("div", { class: "first-screen" }, picture, answer),
      rest,
      injuryCriteria(summary) ?? "",
      job.failure ? failurePanel(job.failure) : "",
      trust,
      html("details", { class: "panel" }, html("summary", {}, "Every number"), allNumbers(summary)),
    );
    if (!opening) return picture.replaceWith(html("p", { class: "panel quiet" }, "There is no recording, so there is no picture."));
    const recording = await this.#showRecording(opening, rest, summary, picture);
    if (!recording) return;
    layers.replaceChildren(layerSentences(summary, boneIn(recording)) ?? "");
  }

  /** The answer to a what-if question. */
  async #showAnswer(summary) {
    const { WhatIfAnswer } = await import("./what_if_answer.js");
    const answer = new WhatIfAnswer(undefined, null, this.#asked);
    answer.takeAll(summary);
    this.#body.append(html("section", { class: "panel" }, answer.element));
  }

  /** Shows the recording that is opening: its picture in `picture` as soon as there is one, the curves in `rest`. */
  async #showRecording(opening, rest, summary, picture = html("div")) {
    const { job } = this;
    const bar = html("progress", { max: 1, value: 0, "aria-label": "Reading the recording" });
    const loading = html("p", { class: "quiet loading" }, `Reading the recording (${bytes(job.recording.bytes)}) `, bar);
    picture.append(loading);
    if (!picture.isConnected) this.#body.append(picture);
    if (!rest.isConnected) this.#body.append(rest);
    const panel = loadPanel();
    const recording = await opening;
    const onFirst = async () => {
      const { RunPanel } = await panel;
      if (this.#ending.signal.aborted) return;
      this.#panel = new RunPanel(job.name, recording, summary);
      this.#panel.begin();
      picture.replaceChildren(this.#panel.stage, loading);
    };
    const first = worstOf(summary) ?? 0;
    const onProgress = (fraction) => {
      bar.value = fraction;
      this.#panel?.grow();
    };
    await recording.read({ first, onFirst, onProgress });
    const { RunPanel } = await panel;
    if (this.#ending.signal.aborted) return null;
    loading.remove();
    this.#panel ??= new RunPanel(job.name, recording, summary);
    picture.replaceChildren(this.#panel.stage);
    rest.replaceChildren(this.#panel.element, this.#downloads(recording));
    await this.#panel.finish();
    return recording;
  }

  #downloads(recording) {
    const { job } = this;
    const fetched = async (path, name) => saveFile(name, await (await request(path)).blob());
    // They know a recording by the end of its name.
    const source = encodeURIComponent(`${address(job.links.recording)}.mcap`);
    const elsewhere = (words, base) =>
      html("a", { class: "button", target: "_blank", rel: "noreferrer", href: `${base}?ds=remote-file&ds.url=${source}`, title: "Opens another site, which then reads the recording from this service, if it can reach it" }, words);
    return html(
      "section",
      { class: "panel downloads", "aria-label": "Downloads" },
      html("h2", {}, "Take it with you"),
      html(
        "div",
        { class: "tools" },
        button(`Recording (MCAP, ${bytes(job.recording.bytes)})`, () => fetched(job.links.recording, `${job.name}.mcap`), { class: "primary" }),
        job.links.summary && button("Summary (JSON)", () => fetched(job.links.summary, `${job.name}-summary.json`)),
        job.links.summary && button("Report (HTML)", () => fetched(`/v1/jobs/${job.id}/report`, `${job.name}-report.html`)),
        job.links.summary && button("Bundle (FHIR)", () => fetched(`/v1/jobs/${job.id}/fhir`, `${job.name}-fhir.json`)),
        job.links.summary && button("Table (CSV)", () => fetched(`/v1/jobs/${job.id}/export.csv`, `${job.name}.csv`)),
        button("Fields for ParaView (tar)", () => fetched(`/v1/jobs/${job.id}/export.vtu.tar`, `${job.name}.tar`)),
        button("Surfaces (STL)", () => fetched(`/v1/jobs/${job.id}/export.stl`, `${job.name}.stl`)),
        button("Surfaces (PLY)", () => fetched(`/v1/jobs/${job.id}/export.ply`, `${job.name}.ply`)),
        button("Layout for Lichtblick and Foxglove", () => saveFile(`${job.name}-layout.json`, JSON.stringify(layoutOf(recording), null, 2), "application/json")),
        elsewhere("Open in Lichtblick ↗", "https://lichtblick-suite.github.io/lichtblick/"),
        elsewhere("Open in Foxglove ↗", "https://app.foxglove.dev/~/view"),
      ),
    );
  }
}

/** The bone {depth_mm} below the place of the impact; of no known depth where it is a held surface by its name; null where nothing is. */
function boneIn(recording) {
  const [bone, line] = [recording.scenery.get("bone"), impactLine(recording)];
  const tissue = recording.scene?.bodies?.find(({ name }) => name === recording.tissue?.name);
  if (!bone) return tissue?.fixed?.some(({ set }) => /bone/i.test(set)) ? { depth_mm: null } : null;
  if (!line) return null;
  const away = Array.from({ length: bone.X.length / 3 }, (_, i) => Math.hypot(...line.centre.map((c, k) => bone.X[3 * i + k] - c)));
  return { depth_mm: 1e3 * Math.min(...away) };
}

/** Why a job failed, where, and what to do. */
function failurePanel(failure) {
  const rest = Object.entries(failure).filter(([key, value]) => !["code", "cause", "message", "remedy"].includes(key) && value != null);
  return html(
    "section",
    { class: "panel alert", role: "alert" },
    html("h2", {}, `Failed: ${failure.code ?? failure.cause ?? "unknown cause"}`),
    failure.message && html("p", {}, failure.message),
    failure.remedy && html("p", {}, html("b", {}, "What to do: "), failure.remedy),
    rest.length ? html("p", { class: "quiet" }, rest.map(([key, value]) => `${key}: ${JSON.stringify(value)}`).join(" · ")) : null,
  );
}
