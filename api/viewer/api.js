// The service's own API, and nothing else: requests, problems, events.

const TOKEN = "contuse.token";

/** The address of a call, beside the page (the service may stand below a path of a proxy). */
export function address(path) {
  return new URL(path.replace(/^\//, ""), document.baseURI).href;
}

/** An answer that is no success, as the service words it (RFC 9457). */
export class ApiProblem extends Error {
  constructor(status, body) {
    super(body.detail ?? body.title ?? `The service answered ${status}.`);
    this.status = status;
    this.body = body;
  }
}

/** The bearer token, kept until the tab is closed. */
export const token = {
  get: () => sessionStorage.getItem(TOKEN),
  set: (value) => (value ? sessionStorage.setItem(TOKEN, value) : sessionStorage.removeItem(TOKEN)),
};

/** Headers with the token, if there is one. */
export function authorised(headers = {}) {
  const bearer = token.get();
  return bearer ? { ...headers, Authorization: `Bearer ${bearer}` } : headers;
}

/** One request; throws an `ApiProblem` unless it succeeds. */
export async function request(path, { headers, ...options } = {}) {
  const answer = await fetch(address(path), { ...options, headers: authorised(headers) });
  if (answer.ok) return answer;
  const isProblem = (answer.headers.get("content-type") ?? "").includes("json");
  throw new ApiProblem(answer.status, isProblem ? await answer.json() : { title: answer.statusText });
}

export async function getJson(path) {
  return (await request(path)).json();
}

/** Posts a text that is JSON already, or a value. */
export async function postJson(path, body, { headers, signal } = {}) {
  const text = typeof body === "string" ? body : JSON.stringify(body);
  const all = { "Content-Type": "application/json", ...headers };
  return (await request(path, { method: "POST", body: text, headers: all, signal })).json();
}

/** Posts a file; `onProgress(part)` says how much of it is sent, 1 when all. What `fetch` cannot: it reports no progress. */
export function upload(path, file, onProgress, signal) {
  return new Promise((resolve, reject) => {
    const sending = new XMLHttpRequest();
    const bodyOf = () => {
      try {
        return JSON.parse(sending.responseText);
      } catch {
        return { title: sending.statusText };
      }
    };
    sending.open("POST", address(path));
    for (const [name, value] of Object.entries(authorised({ "Content-Type": "application/octet-stream" }))) sending.setRequestHeader(name, value);
    sending.upload.onprogress = ({ loaded, total }) => onProgress(total ? Math.min(1, loaded / total) : 1);
    sending.onload = () => (sending.status < 300 ? resolve(bodyOf()) : reject(new ApiProblem(sending.status, bodyOf())));
    sending.onerror = () => reject(new Error("The upload was interrupted: the service closed the connection, or cannot be reached."));
    sending.onabort = () => reject(new DOMException("The upload was cancelled.", "AbortError"));
    signal.addEventListener("abort", () => sending.abort());
    sending.send(file);
  });
}

/** Follows a job: calls `onEvent({id, event, data})` until the job has ended or `signal` aborts. */
export async function followEvents(path, onEvent, signal) {
  let last = 0;
  // `EventSource` cannot send a token.
  for (let failures = 0; !signal.aborted; ) {
    try {
      const headers = { Accept: "text/event-stream", "Last-Event-ID": String(last) };
      const answer = await request(path, { headers, signal });
      if (answer.status === 204) return;
      for await (const event of parseEvents(answer.body)) {
        last = Number(event.id) || last;
        failures = 0;
        onEvent(event);
        if (["succeeded", "failed", "cancelled"].includes(event.event)) return;
      }
    } catch (error) {
      if (signal.aborted) return;
      if (error instanceof ApiProblem || failures >= 5) throw error;
    }
    failures += 1;
    await new Promise((resolve) => setTimeout(resolve, 300 * failures));
  }
}

/** Server-sent events from the bytes of an answer. */
async function* parseEvents(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    text += value;
    for (let end; (end = text.indexOf("\n\n")) >= 0; text = text.slice(end + 2)) {
      const fields = {};
      for (const line of text.slice(0, end).split("\n").filter((l) => !l.startsWith(":"))) {
        const colon = line.indexOf(":");
        fields[line.slice(0, colon)] = line.slice(colon + 1).trimStart();
      }
      if (fields.data) yield { id: fields.id, event: fields.event, data: JSON.parse(fields.data) };
    }
  }
}
