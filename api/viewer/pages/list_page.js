// The jobs, newest first.

import { getJson } from "../api.js";
import { button, html, table } from "../dom.js";
import { bytes, moment, timeUnit, withUnit } from "../format.js";

/** A state as a badge. */
export function stateBadge(state) {
  const kinds = { succeeded: "good", failed: "bad", cancelled: "warn", running: "busy" };
  return html("span", { class: `badge ${kinds[state] ?? ""}` }, state);
}

export async function listPage() {
  const holder = html("div");
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
    holder.append(jobTable(page.jobs, choose));
    if (page.next_cursor) {
      const more = button("Older ones", () => (more.remove(), load(page.next_cursor)));
      holder.append(more);
    }
  };
  await load(null);
  const element = html(
    "div",
    {},
    html("div", { class: "title" }, html("h1", {}, "Impacts"), html("div", { class: "tools" }, compare, html("a", { class: "button primary", href: "#/new" }, "New impact"))),
    holder,
  );
  return { title: "Impacts", element };
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

function jobTable(jobs, choose) {
  const rows = jobs.map((job) => {
    const unit = timeUnit(job.end_time_s);
    const box = html("input", { type: "checkbox", "aria-label": `Compare ${job.name}`, disabled: !job.recording, onchange: () => choose(job.id, box.checked) });
    return [
      html("a", { href: `#/job/${job.id}` }, job.name),
      stateBadge(job.state),
      `${withUnit(job.simulated_time_s * unit.factor, unit.name)} of ${withUnit(job.end_time_s * unit.factor, unit.name)}`,
      moment(job.created_at),
      job.recording ? bytes(job.recording.bytes) : "–",
      box,
    ];
  });
  return table("Jobs, newest first", ["scene", "state", "simulated", "submitted", "recording", "compare"], rows);
}
