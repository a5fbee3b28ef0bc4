// Which what-if question was asked about which impact: the service keeps only the scene, so this tab remembers.

const QUESTIONS = "contuse.questions";

const remembered = () => JSON.parse(sessionStorage.getItem(QUESTIONS) ?? "{}");

/** The page of a question about an impact, by the ids of their jobs. */
export function questionPage(impact, question) {
  return `#/what-if/${impact}?job=${question}`;
}

/** Remembers which impact a question was asked about. */
export function remember(question, impact) {
  sessionStorage.setItem(QUESTIONS, JSON.stringify({ ...remembered(), [question]: impact }));
}

/** The page on which a question was asked; null for jobs that are none, and for questions of others. */
export function pageOfQuestion(job) {
  const impact = remembered()[job.id];
  return impact ? questionPage(impact, job.id) : null;
}
