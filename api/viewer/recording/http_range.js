// A file at an address, read a range at a time: what the MCAP reader calls a readable.

import { address, authorised, ApiProblem } from "../api.js";

/** Reads of the index are small and near each other: one request fetches at least so much [bytes]. */
const AT_LEAST = 64 << 10;

export class HttpRange {
  #path;
  #etag = null;
  #size = null;
  #held = { from: 0, bytes: new Uint8Array(0) };
  /** Bytes that came over the wire. */
  received = 0;

  constructor(path) {
    this.#path = path;
  }

  /** Length of the file. The first request also shows which file it is: of a running job, a numbered snapshot. */
  async size() {
    if (this.#size == null) await this.#fetch(0, AT_LEAST);
    return BigInt(this.#size);
  }

  async read(offset, size) {
    const [from, length] = [Number(offset), Number(size)];
    const inside = () => from >= this.#held.from && from + length <= this.#held.from + this.#held.bytes.length;
    if (!inside()) await this.#fetch(from, Math.max(length, AT_LEAST));
    if (!inside()) throw new Error(`The recording has no ${length} bytes at ${from}.`);
    const start = from - this.#held.from;
    return this.#held.bytes.subarray(start, start + length);
  }

  async #fetch(from, length) {
    const last = this.#size == null ? from + length - 1 : Math.min(from + length, this.#size) - 1;
    const headers = authorised({ Range: `bytes=${from}-${last}`, ...(this.#etag && { "If-Range": this.#etag }) });
    const answer = await fetch(address(this.#path), { headers, cache: "no-store" });
    if (!answer.ok) throw new ApiProblem(answer.status, await answer.json());
    const etag = answer.headers.get("etag");
    if (this.#etag && etag !== this.#etag) throw new Error("The recording has changed while it was read: open it again.");
    const range = answer.headers.get("content-range");
    const bytes = new Uint8Array(await answer.arrayBuffer());
    this.received += bytes.length;
    this.#size ??= range ? Number(range.split("/")[1]) : bytes.length;
    this.#etag = etag;
    this.#held = { from: answer.status === 206 ? from : 0, bytes };
  }
}
