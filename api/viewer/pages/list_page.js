// The jobs, newest first.

import { getJson } from "../api.js";
import { button, html, table } from "../dom.js";
import { ABOUT_MARKS, bytes, marked, moment, number, setting, within } from "../format.js";
import { titleOf } from "./ask_address.js";
import { pageOfQuestion } from "./asked.js";
import { reached } from "./progress.js";
import { stateBadge } from "./state_badge.js";

/** Rest between two looks at jobs that wait or run [ms]. */
const REST = 1500;
const isOver = (job) => ["succeeded", "failed", "cancelled"].includes(job.state);

export async function listPage() {
  const watched = new Map();
  const holder = html("div");
  const legend = html("p", { class: "quiet", hidden: true }, ABOUT_MARKS);
  const chosen = [];
  const compare = html("a", { class: "button disabled", "aria-disabled": "true" }, "Compare two");
  const choose = (id, isChosen) => {
    chosen.splice(0, chosen.length, ...chosen.filter((c) => c !== id), ...(isChosen ? [id] : []));
    const isPair = chosen.length === 2;
    compare.classList.toggle("disabled", !isPair);
    compare.setAttribute("aria-disabled", String(!isPair));
    if (isPair) compare.href = `#/compare/${chosen.join("/")}`;
    else compare.removeAttribute("href");
  };
  const load = async (cursor) => {
    const page = await getJson(`/v1/jobs?limit=50${cursor ? `&cursor=${cursor}` : ""}`);
    if (!page.jobs.length && !cursor) return holder.replaceChildren(welcome());
    holder.append(jobTable(page.jobs, choose, watched));
    legend.hidden = false;
    if (page.next_cursor) {
      const more = button("Older ones", () => (more.remove(), load(page.next_cursor)));
      holder.append(more);
    }
  };
  await load(null);
  const element = html(
    "div",
    {},
    html("div", { class: "title" }, html("h1", {}, "Impacts"), html("div", { class: "tools" }, compare, html("a", { class: "button", href: "#/ask" }, "Ask: at which speed?"), html("a", { class: "button primary", href: "#/new" }, "New impact"))),
    holder,
    legend,
  );
  const timer = setInterval(() => look(watched).catch(() => clearInterval(timer)), REST);
  return { title: "Impacts", element, leave: () => clearInterval(timer) };
}

/** Looks again at the jobs that had not ended, and shows where they stand. */
async function look(watched) {
  for (const [id, show] of watched) {
    const job = await getJson(`/v1/jobs/${id}`);
    show(job);
    if (isOver(job)) watched.delete(id);
  }
}

/** The numbers of a run in a list: [name on the wire, unit, what it is]. */
const NUMBERS = [["peak_force_n", "N", "peak force"], ["largest_patch_area_mm2", "mm²", "largest contact patch"], ["stress_depth_mm", "mm", "depth of stress"], ["energy_given_j", "J", "energy given to the tissue"]];

/** What flies, and how fast. */
function projectileWords({ headline }) {
  if (!headline?.projectile) return "–";
  const { projectile, speed_m_per_s: speed } = headline;
  return speed > 0 ? `${projectile}, ${setting(Number(speed.toPrecision(4)))} m/s` : projectile;
}

/** The main numbers of a run that has ended, each with what it is as a hint. */
function numberWords({ headline, withheld }) {
  if (withheld) return "withheld";
  const found = NUMBERS.filter(([key]) => headline?.numbers[key]);
  if (!found.length) return "–";
  const above = headline.threshold_pa == null ? "" : ` above ${setting(headline.threshold_pa / 1e3)} kPa`;
  return html("span", { class: "list-numbers" }, found.map(([key, unit, what]) => {
    const { value, error, resolved, lower_bound: isLeast } = headline.numbers[key];
    const about = `${what}${key === "stress_depth_mm" ? above : ""}${error == null ? ", error unknown" : `, ± ${number(error, 2)} ${unit}`}`;
    const level = key === "stress_depth_mm" && above ? html("small", {}, above) : "";
    return html("span", { title: about }, `${marked(within(value, error), resolved, isLeast)} ${unit}`, level);
  }));
}

/** Where a job stands: its state, how far it is, the size of what it left, what flew, and its numbers. */
function standing(job) {
  return [stateBadge(job), reached(job), job.recording ? bytes(job.recording.bytes) : "–", projectileWords(job), numberWords(job)];
}

function welcome() {
  return html(
    "section",
    { class: "panel welcome" },
    html("h2", {}, "This projectile hits this tissue at this speed: what happens to the tissue?"),
    html("p", {}, "Nothing has been computed yet. Begin with an example, change what you like, and see the force, the patch, the depth and the energy, each with its error."),
    html("a", { class: "button primary", href: "#/new" }, "New impact"),
  );
}

/** A table of jobs; those to look at again go into `watched`. */
function jobTable(jobs, choose, watched) {
  const rows = jobs.map((job) => {
    const box = html("input", { type: "checkbox", "aria-label": `Compare ${titleOf(job.name)}`, onchange: () => choose(job.id, box.checked) });
    const cells = standing(job).map((content) => html("span", {}, content));
    const show = (now) => {
      standing(now).forEach((content, i) => cells[i].replaceChildren(content));
      box.disabled = !now.recording;
    };
    show(job);
    if (!isOver(job)) watched.set(job.id, show);
    return [html("a", { href: pageOfQuestion(job) ?? `#/job/${job.id}` }, titleOf(job.name)), cells[3], cells[4], cells[0], cells[1], moment(job.created_at), cells[2], box];
  });
  const names = ["scene", "projectile", "force · patch · depth · energy", "state", "done", "submitted", "recording", "compare"];
  return table("Jobs, newest first", names, rows);
}
