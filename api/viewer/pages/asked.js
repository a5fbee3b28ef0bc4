// What-if questions of this tab: which job answers each, so that nothing is computed twice, and on which page it was asked.

import { ApiProblem, getJson, postJson } from "../api.js";

const ASKED = "contuse.asked";
/** So many questions are remembered, the last ones. */
const MOST = 50;

/** {id, text, page}, in the order in which they were asked. */
const remembered = () => JSON.parse(sessionStorage.getItem(ASKED) ?? "[]");

/** Remembers of a question what is given, and what was known of it before. */
function note(id, given) {
  const all = remembered();
  const others = all.filter((one) => one.id !== id);
  const known = all.find((one) => one.id === id);
  sessionStorage.setItem(ASKED, JSON.stringify([...others, { ...known, ...given, id }].slice(-MOST)));
}

/** A job as the service describes it; null if there is none of this id. */
async function jobLeft(id) {
  try {
    return await getJson(`/v1/jobs/${id}`);
  } catch (error) {
    if (error instanceof ApiProblem && [400, 404, 410].includes(error.status)) return null;
    throw error;
  }
}

/**
 * The id of the job of a question: `known`, if its scene has the name of this one; otherwise that which this tab sent before, unless it is
 * gone, failed or was cancelled; otherwise of a new one.
 */
export async function jobOf(question, signal, known = null) {
  const text = JSON.stringify(question);
  const given = known && (await jobLeft(known));
  if (given && given.name === `what if: ${question.scene?.name}`) return note(known, { text }), known;
  const before = remembered().findLast((one) => one.text === text);
  const job = before && (await jobLeft(before.id));
  if (job && !["failed", "cancelled"].includes(job.state)) return job.id;
  const { id } = await postJson("/v1/what-if", question, { signal });
  note(id, { text });
  return id;
}

/** Ends the computation of a question. */
export function stop(id) {
  return postJson(`/v1/jobs/${id}/cancel`, {});
}

/** Remembers the page, as an address within this one, on which a question was asked. */
export function remember(id, page) {
  note(id, { page });
}

/** The page on which a question was asked; null for jobs that are none, and for questions of others. */
export function pageOfQuestion(job) {
  return remembered().find(({ id }) => id === job.id)?.page ?? null;
}
