// A file at an address, read a range at a time: what the MCAP reader calls a readable.

import { address, authorised, ApiProblem } from "../api.js";

/** Reads of the index are small and near each other: one request fetches at least so much [bytes]. */
const AT_LEAST = 64 << 10;
/** So many pieces of the file are held: its beginning, its end, an index, and what it points to. */
const HELD = 4;

export class HttpRange {
  #path;
  #etag = null;
  #size = null;
  #held = [];
  /** Bytes that came over the wire. */
  received = 0;

  constructor(path) {
    this.#path = path;
  }

  /** Length of the file. The first request also shows which file it is: of a running job, a numbered snapshot. */
  async size() {
    if (this.#size == null) await this.#fetch(`-${AT_LEAST}`);
    return BigInt(this.#size);
  }

  async read(offset, size) {
    const [from, length] = [Number(offset), Number(size)];
    const inside = (piece) => from >= piece.from && from + length <= piece.from + piece.bytes.length;
    if (!this.#held.some(inside)) await this.#fetch(`${from}-${Math.min(from + Math.max(length, AT_LEAST), this.#size ?? Infinity) - 1}`);
    const piece = this.#held.find(inside);
    if (!piece) throw new Error(`The recording has no ${length} bytes at ${from}.`);
    const start = from - piece.from;
    return piece.bytes.subarray(start, start + length);
  }

  async #fetch(part) {
    const headers = authorised({ Range: `bytes=${part}`, ...(this.#etag && { "If-Range": this.#etag }) });
    const answer = await fetch(address(this.#path), { headers, cache: "no-store" });
    if (!answer.ok) throw new ApiProblem(answer.status, await answer.json());
    const etag = answer.headers.get("etag");
    if (this.#etag && etag !== this.#etag) throw new Error("The recording changed while it was being read: open it again.");
    const range = answer.headers.get("content-range");
    const bytes = new Uint8Array(await answer.arrayBuffer());
    this.received += bytes.length;
    this.#size ??= range ? Number(range.split("/")[1]) : bytes.length;
    this.#etag = etag;
    const from = range ? Number(range.match(/\d+/)[0]) : 0;
    this.#held = [...this.#held, { from, bytes }].slice(-HELD);
  }
}
