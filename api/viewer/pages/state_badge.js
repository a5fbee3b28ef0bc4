// The state of a job as a badge.

import { html } from "../dom.js";

/** The state of a job: that of a run whose numbers are withheld says so. */
export function stateBadge({ state, withheld }) {
  if (withheld && state === "succeeded") return html("span", { class: "badge warn" }, "withheld");
  const kinds = { succeeded: "good", failed: "bad", cancelled: "warn", running: "busy" };
  return html("span", { class: `badge ${kinds[state] ?? ""}` }, state);
}
