// A file at an address, read a range at a time: what the MCAP reader calls a readable.

import { address, authorised, ApiProblem } from "../api.js";

/** Reads of the index are small and near each other: one request fetches at least so much [bytes]. */
const AT_LEAST = 64 << 10;
/** So many pieces of the file are held: its beginning, its end, the one that is read, and the next. */
const HELD = 4;

export class HttpRange {
  #path;
  #etag = null;
  #size = null;
  /** Pieces {from, to, bytes}, with the promise of their bytes. */
  #held = [];
  #expected = [];

  constructor(path) {
    this.#path = path;
  }

  /** Length of the file. The first request also shows which file it is: of a running job, a numbered snapshot. */
  async size() {
    if (this.#size == null) await this.#end();
    return BigInt(this.#size);
  }

  async read(offset, size) {
    const from = Number(offset);
    const to = from + Number(size);
    const piece = this.#pieceWith(from, to);
    const bytes = await piece.bytes;
    if (piece.from + bytes.length < to) throw new Error(`The recording has no ${size} bytes at ${from}.`);
    return bytes.subarray(from - piece.from, to - piece.from);
  }

  /** Spans {from, to} of the file that will be read, in this order: each is fetched as a whole, the next one while one is in use. */
  expect(spans) {
    this.#expected = spans;
    if (spans.length) this.#fetchFrom(0);
  }

  #pieceWith(from, to) {
    const holds = (span) => from >= span.from && to <= span.to;
    const index = this.#expected.findIndex(holds);
    if (index >= 0) this.#fetchFrom(index);
    return this.#held.find(holds) ?? this.#fetch({ from, to: Math.min(Math.max(to, from + AT_LEAST), this.#size ?? Infinity) });
  }

  /** Fetches an expected span and the next one, unless they are held. */
  #fetchFrom(index) {
    for (const span of this.#expected.slice(index, index + 2)) {
      if (!this.#held.some(({ from, to }) => from <= span.from && to >= span.to)) this.#fetch(span);
    }
  }

  /** The end of the file, which has the index. */
  async #end() {
    const { from, bytes } = await this.#request(`-${AT_LEAST}`);
    this.#held.push({ from, to: from + bytes.length, bytes });
  }

  #fetch({ from, to }) {
    const piece = { from, to, bytes: this.#request(`${from}-${to - 1}`).then(({ bytes }) => bytes) };
    // It fails where it is read.
    piece.bytes.catch(() => (this.#held = this.#held.filter((held) => held !== piece)));
    this.#held = [...this.#held, piece].slice(-HELD);
    return piece;
  }

  async #request(part) {
    const headers = authorised({ Range: `bytes=${part}`, ...(this.#etag && { "If-Range": this.#etag }) });
    const answer = await fetch(address(this.#path), { headers, cache: "no-store" });
    if (!answer.ok) throw new ApiProblem(answer.status, await answer.json());
    const etag = answer.headers.get("etag");
    if (this.#etag && etag !== this.#etag) throw new Error("The recording changed while it was being read: open it again.");
    const range = answer.headers.get("content-range");
    const bytes = new Uint8Array(await answer.arrayBuffer());
    this.#size ??= range ? Number(range.split("/")[1]) : bytes.length;
    this.#etag = etag;
    return { from: range ? Number(range.match(/\d+/)[0]) : 0, bytes };
  }
}
