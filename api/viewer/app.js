// The page: which part of it the address asks for, and the token where the service wants one.

import { ApiProblem, getJson, token } from "./api.js";
import { button, html } from "./dom.js";

/** What is behind `#/`: a function that loads the modules of a page and opens it. */
const ROUTES = [
  [/^$/, async () => (await import("./pages/list_page.js")).listPage()],
  [/^ask(?:\?(.*))?$/, async (query) => (await import("./pages/ask_page.js")).askPage(query)],
  [/^new(?:\/([\w-]+))?(\?accuracy)?$/, async (id, accuracy) => (await import("./pages/submit_page.js")).submitPage(id, Boolean(accuracy))],
  [/^job\/([\w-]+)$/, openJob],
  [/^what-if\/([\w-]+)(?:\?job=([\w-]+))?$/, async (id, question) => (await import("./pages/what_if_page.js")).whatIfPage(id, question)],
  [/^compare(?:\/([\w-]+))?(?:\/([\w-]+))?(\?since-contact)?$/, async (a, b, since) => (await import("./pages/compare_page.js")).comparePage(a, b, Boolean(since))],
];

/** A job is asked for while the modules of its page come. */
async function openJob(id) {
  const [job, { jobPage }] = await Promise.all([getJson(`/v1/jobs/${id}`), import("./pages/job_page.js")]);
  return jobPage(job);
}

const main = document.getElementById("main");
let leave = () => {};
let visit = 0;

async function show() {
  const current = ++visit;
  leave();
  leave = () => {};
  const path = location.hash.replace(/^#\/?/, "");
  markCurrent(path);
  const [route, open] = ROUTES.find(([pattern]) => pattern.test(path)) ?? [/^/, notFound];
  main.replaceChildren(html("p", { class: "quiet" }, "Loading…"));
  try {
    const page = await open(...path.match(route).slice(1));
    if (current !== visit) return page.leave?.();
    document.title = `${page.title} · Contuse`;
    leave = page.leave ?? (() => {});
    main.replaceChildren(page.element);
  } catch (error) {
    if (current === visit) main.replaceChildren(failure(error));
  }
}

function markCurrent(path) {
  for (const link of document.querySelectorAll("nav a")) {
    const isCurrent = link.hash.replace(/^#\/?/, "").split("/")[0] === path.split(/[/?]/)[0] && link.hash !== "";
    if (isCurrent) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
}

function notFound() {
  return { title: "Not found", element: html("p", { class: "panel" }, "There is no such page. ", html("a", { href: "#/" }, "To the impacts")) };
}

function failure(error) {
  if (error instanceof ApiProblem && error.status === 401) return tokenForm();
  console.error(error);
  const remedy = error.body?.remedy;
  return html("div", { class: "panel", role: "alert" }, html("h1", {}, "That did not work"), html("p", {}, error.message), remedy && html("p", {}, remedy), button("Try again", show));
}

function tokenForm() {
  const input = html("input", { type: "password", autocomplete: "off", required: true });
  const enter = (event) => {
    event.preventDefault();
    token.set(input.value.trim());
    show();
  };
  return html(
    "form",
    { class: "panel narrow", onsubmit: enter },
    html("h1", {}, "This service requires a token"),
    html("label", { class: "field" }, html("span", {}, "Token"), input),
    html("p", { class: "quiet" }, "It is kept until this tab is closed, and sent to this service alone."),
    html("button", { type: "submit", class: "primary" }, "Continue"),
  );
}

window.addEventListener("hashchange", () => {
  show();
  main.focus({ preventScroll: true });
  window.scrollTo(0, 0);
});
show();
