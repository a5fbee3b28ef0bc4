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

/** A short word for a text, 52 bits: the service compares the texts themselves (two rounds of multiplication, as in MurmurHash). */
function digestOf(text) {
  let [a, b] = [0x9e3779b9, 0x85ebca6b];
  for (let i = 0; i < text.length; i++) {
    const code = text.charCodeAt(i);
    a = Math.imul(a ^ code, 0x85ebca77);
    b = Math.imul(b ^ code, 0xc2b2ae3d);
  }
  a ^= Math.imul(a ^ (b >>> 15), 0x735a2d97);
  b ^= Math.imul(b ^ (a >>> 15), 0xcaf649a9);
  return (0x100000 * (b >>> 0) + ((a >>> 0) >>> 12)).toString(36);
}

/**
 * The job of a question, whoever asked it: one key for each text and build of the program, so that the service answers with the job that there is. A
 * job that failed or was cancelled is no answer, and neither is one of another text with the same digest: then the next key.
 */
async function askedOnce(text, signal) {
  const name = ["ask", document.documentElement.dataset.build, digestOf(text)].join("-");
  for (let turn = 0; ; turn++) {
    try {
      const job = await postJson("/v1/what-if", text, { headers: { "Idempotency-Key": `${name}-${turn}` }, signal });
      if (!["failed", "cancelled"].includes(job.state) && !job.cancel_requested) return job;
    } catch (error) {
      if (!(error instanceof ApiProblem && error.status === 409)) throw error;
    }
  }
}

/**
 * The id of the job of a question: `known`, if its scene has the name of this one; otherwise that which this tab sent before, unless it is
 * gone, failed or was cancelled; otherwise that which another tab or reader of the same owner sent; otherwise of a new one.
 */
export async function jobOf(question, signal, known = null) {
  const text = JSON.stringify(question);
  const given = known && (await jobLeft(known));
  if (given && given.name === `what if: ${question.scene?.name}`) return note(known, { text }), known;
  const before = remembered().findLast((one) => one.text === text);
  const job = before && (await jobLeft(before.id));
  if (job && !["failed", "cancelled"].includes(job.state)) return job.id;
  const { id } = await askedOnce(text, signal);
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
