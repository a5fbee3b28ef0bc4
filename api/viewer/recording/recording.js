// A recording, read through its index: first the frame that is shown first, then everything from the beginning to the end.

import { McapIndexedReader } from "../vendor/mcap/McapIndexedReader.js";
import { boneOf } from "../mesh/bone.js";
import { Cells } from "../mesh/cells.js";
import { decompress } from "../vendor/fzstd/index.mjs";
import { HttpRange } from "./http_range.js";
import { decoderOf } from "./protobuf.js";
import { Series } from "./series.js";

/** Frames that are kept in memory may take so much [bytes]; of longer recordings every second one is shown, or fewer. */
const FRAME_BUDGET = 512 << 20;

const ARRAYS = { f32: Float32Array, f64: Float64Array, u32: Uint32Array, u8: Uint8Array };

/** A `PackedArray` as a typed array of its own: views would keep whole chunks in memory. */
function unpacked(packed) {
  return new ARRAYS[packed.dtype](packed.data.slice().buffer);
}

/** Log times of the messages of one step follow each other by nanoseconds, fewer than this. */
const NANOSECONDS_OF_STEP = 100_000n;

/** Decompresses a chunk. fzstd compares its output buffer with 1, for which JavaScript would write all of it out as text. */
function unzstd(data, size) {
  return decompress(data, Object.assign(new Uint8Array(Number(size)), { valueOf: () => NaN }));
}

/** What is said of recordings whose positions are elsewhere. */
const TOO_OLD = "An earlier version of Contuse made this recording: its fields have no displacements. Run its scene again to see them.";

/** The elements of a reference mesh: hexahedra alone, or cells with their types. */
function cellsOf(message) {
  return message.cell_types ? new Cells(unpacked(message.cell_nodes), unpacked(message.cell_types)) : new Cells(unpacked(message.hexes));
}

/** Waits until the browser has shown what was drawn; a hidden page shows nothing. */
function pictureShown() {
  if (document.hidden) return Promise.resolve();
  return new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
}

const xyz = (vector) => (vector ? [vector.x, vector.y, vector.z] : [0, 0, 0]);

export class Recording {
  /** Metadata of the run and of its end, by name of the record. */
  run = {};
  ending = {};
  /** Bodies: name, role, and `X` [m], `cells` (deformable) or `surface` {points, triangles} (rigid). */
  bodies = new Map();
  /** States at the field times: `time` [s], `bodies` by name ({positions, fields, eroded} or {pose}), `contacts` by pair. */
  frames = [];
  series = new Series();
  /** Every how many field times a frame is kept. */
  stride = 1;

  /** The scene document, and what of it stands still without a mesh of its own, by name. */
  scene = null;
  scenery = new Map();

  /** Opens the recording at an address: what it says of itself and of the scene, and the meshes. */
  static async open(path) {
    const source = new HttpRange(path);
    const reader = await McapIndexedReader.Initialize({ readable: source, decompressHandlers: { zstd: unzstd } });
    const recording = new Recording();
    [recording.#source, recording.#reader] = [source, reader];
    for await (const record of reader.readMetadata()) {
      const metadata = Object.fromEntries(record.metadata);
      if (record.name === "contuse.run") recording.run = metadata;
      if (record.name === "contuse.ending") recording.ending = metadata;
    }
    for await (const attachment of reader.readAttachments({ name: "scene.json" })) {
      recording.scene = JSON.parse(new TextDecoder().decode(attachment.data));
    }
    const bone = boneOf(recording.scene);
    if (bone) recording.scenery.set(bone.name, bone);
    recording.#channels = recording.#channelsOf(reader);
    for await (const message of recording.#messages(["reference"])) recording.#take(message);
    return recording;
  }

  /**
   * Reads all of it. Of its frames the one nearest to the time `first` [s] is fetched before the others: as soon as it is there
   * `onFirst()` is called, then, while the others come, `onProgress(fraction)`.
   */
  async read({ first = 0, onProgress = () => {}, onFirst = () => {} } = {}) {
    await this.#readFirst(first);
    if (this.frames.length) {
      await onFirst();
      await pictureShown();
    }
    await this.#readAll(onProgress);
    return this;
  }

  /** The scene document that the recording at an address carries, as text. */
  static async sceneText(path) {
    const reader = await McapIndexedReader.Initialize({ readable: new HttpRange(path), decompressHandlers: {} });
    for await (const attachment of reader.readAttachments({ name: "scene.json" })) {
      return new TextDecoder().decode(attachment.data);
    }
    throw new Error("The recording carries no scene.");
  }

  /** Topics with the decoders of their messages, by number: those of which something is shown. */
  #channelsOf(reader) {
    const decoders = new Map();
    this.topics = [...reader.channelsById.values()].map((channel) => channel.topic);
    const deforms = (name) => this.topics.includes(`/reference/${name}`);
    const channels = new Map();
    for (const [id, { topic, schemaId }] of reader.channelsById) {
      const [, kind, name] = topic.split("/");
      if (kind === "points" || kind === "log" || (kind === "mesh" && deforms(name))) continue;
      const schema = reader.schemasById.get(schemaId);
      if (!decoders.has(schema.name)) decoders.set(schema.name, decoderOf(schema.name, schema.data));
      channels.set(id, { topic, kind, name, decode: decoders.get(schema.name) });
    }
    return channels;
  }

  /** The messages of topics of some kinds, between two log times; what holds them is fetched ahead. */
  #messages(kinds, { startTime, endTime } = {}) {
    const wanted = [...this.#channels].filter(([, { kind }]) => kinds.includes(kind));
    const isWanted = (chunk) => wanted.some(([id]) => chunk.messageIndexOffsets.has(id)) && !(chunk.messageEndTime < startTime || chunk.messageStartTime > endTime);
    const spanOf = ({ chunkStartOffset: from, chunkLength, messageIndexLength }) => ({ from: Number(from), to: Number(from + chunkLength + messageIndexLength) });
    this.#source.expect(this.#reader.chunkIndexes.filter(isWanted).map(spanOf));
    return this.#reader.readMessages({ topics: wanted.map(([, { topic }]) => topic), startTime, endTime });
  }

  /** Reads the fields, contacts and poses of the frame nearest to a time. */
  async #readFirst(time) {
    const times = JSON.parse(this.run.field_times_s ?? "[]").filter((t) => t <= Number(this.ending.time_s ?? Infinity));
    const [nearest] = times.sort((a, b) => Math.abs(a - time) - Math.abs(b - time));
    if (nearest == null) return;
    const startTime = BigInt(Math.max(0, Math.floor(nearest * Number(this.run.time_factor) * 1e9) - 1));
    const range = { startTime, endTime: startTime + NANOSECONDS_OF_STEP };
    for await (const message of this.#messages(["contact", "pose", "mesh", "stress"], range)) this.#take(message, { isAlone: true });
  }

  async #readAll(onProgress) {
    const counts = this.#reader.statistics?.channelMessageCounts ?? new Map();
    const count = [...this.#channels.keys()].reduce((sum, id) => sum + Number(counts.get(id) ?? 0n), 0);
    const kinds = new Set([...this.#channels.values()].map(({ kind }) => kind));
    kinds.delete("reference");
    let seen = 0;
    for await (const message of this.#messages([...kinds])) {
      this.#take(message);
      if (++seen % 200 === 0) {
        onProgress(count ? Math.min(seen / count, 1) : 0);
        // The page goes on answering.
        await new Promise((resolve) => setTimeout(resolve));
      }
    }
    this.frames = this.frames.filter((frame, i) => i % this.stride === 0 || i === this.frames.length - 1);
    onProgress(1);
  }

  /** Takes in one message; one that `isAlone` is no part of the curves. */
  #take({ channelId, data, publishTime: at }, { isAlone = false } = {}) {
    const { kind, name, decode } = this.#channels.get(channelId);
    const message = decode(data);
    if (kind === "energy") this.series.takeEnergy(message);
    else if (kind === "contact") {
      if (!isAlone) this.series.takeForces(message);
      this.#latestContacts = { at, message };
    } else if (kind === "reference") this.#takeReference(name, message);
    else if (kind === "pose") this.#latestPoses.set(name, { at, message });
    else if (kind === "stress") this.#takeFields(name, message, at);
    else if (kind === "mesh") this.#takeRigidMesh(name, message, at);
    else if (kind === "summary") this.latestSummary = JSON.parse(message.json);
  }

  #source;
  #reader;
  #channels;
  /** Names of bodies by their part of the topic. */
  #names = new Map();
  #latestContacts = null;
  #latestPoses = new Map();
  /** Elements that are gone (1) or not (0), by part of the topic; the same array as long as none are added. */
  #eroded = new Map();
  #bytesOfFrames = 0;

  #takeReference(topicName, message) {
    const V = xyz(message.flight_velocity_m_per_s);
    const body = { name: message.body, role: message.role, parts: this.#partsOf(message), V };
    body.X = unpacked(message.positions);
    body.cells = cellsOf(message);
    body.partOf = unpacked(message.part_of);
    this.bodies.set(body.name, body);
    this.#names.set(topicName, body.name);
  }

  /** Names of the parts; the only part of a generated mesh is called by its shape, and better by the body: gel, not block. */
  #partsOf({ body, parts }) {
    const isGenerated = this.scene?.bodies?.some(({ name, mesh }) => name === body && mesh?.generator);
    return isGenerated && parts.length === 1 ? [body] : parts;
  }

  /** The frame of this moment, made when it is the first message of it; frames are in the order of time. */
  #frameAt(at, time) {
    const next = this.frames.findLastIndex((frame) => frame.at < at) + 1;
    if (this.frames[next]?.at === at) return this.frames[next];
    const frame = { at, time, bodies: new Map(), contacts: null };
    if (this.#latestContacts?.at === at) frame.contacts = contactsOf(this.#latestContacts.message);
    this.frames.splice(next, 0, frame);
    this.#keepWithinBudget();
    return frame;
  }

  /** Lets the fields of frames between the kept ones go. */
  #keepWithinBudget() {
    if (this.#bytesOfFrames < FRAME_BUDGET) return;
    this.stride *= 2;
    this.frames = this.frames.filter((_, i) => i % 2 === 0);
    this.#bytesOfFrames /= 2;
  }

  #takeFields(topicName, { nodal, element, time_s }, at) {
    const { name, X, V } = this.bodies.get(this.#names.get(topicName));
    const arrays = new Map(nodal.map((array) => [array.name, unpacked(array)]));
    const u = arrays.get("displacement_m");
    if (!u) throw new Error(TOO_OLD);
    const positions = u.map((value, i) => X[i] + V[i % 3] * Math.max(time_s, 0) + value);
    const fields = Object.fromEntries(nodal.map((array) => [array.name, array.components === 3 ? norms(arrays.get(array.name)) : arrays.get(array.name)]));
    this.#frameAt(at, time_s).bodies.set(name, { positions, fields, eroded: this.#erodedOf(topicName, element) });
    this.#bytesOfFrames += (positions.length / 3) * 4 * (3 + nodal.length);
  }

  #erodedOf(topicName, element) {
    const found = element.find((array) => array.name === "eroded");
    const eroded = found && unpacked(found);
    const known = this.#eroded.get(topicName);
    if (eroded?.some((gone, e) => gone !== (known?.[e] ?? 0))) this.#eroded.set(topicName, eroded);
    return this.#eroded.get(topicName) ?? null;
  }

  #takeRigidMesh(topicName, update, at) {
    const [entity] = update.entities;
    const [mesh] = entity.triangles;
    if (!this.bodies.has(entity.id)) {
      const points = Float32Array.from(mesh.points.flatMap((p) => [p.x, p.y, p.z]));
      const role = this.#latestPoses.get(topicName)?.message.role ?? "other";
      this.bodies.set(entity.id, { name: entity.id, role, surface: { points, triangles: Uint32Array.from(mesh.indices) } });
    }
    const { position, orientation: q } = mesh.pose;
    this.#frameAt(at, Number(at) * 1e-9).bodies.set(entity.id, {
      pose: { position: xyz(position), orientation: [q.x, q.y, q.z, q.w] },
    });
  }

  /** All bodies that can be drawn, with those that stand still. */
  get drawn() {
    return new Map([...this.bodies, ...this.scenery]);
  }

  /** The body of role `tissue`, or else the first that deforms. */
  get tissue() {
    const deformable = [...this.bodies.values()].filter((body) => body.cells);
    return deformable.find((body) => body.role === "tissue") ?? deformable[0];
  }

  /** Simulated time at the end of the run [s]. */
  get endTime() {
    return Number(this.run.end_time_s ?? this.frames.at(-1)?.time ?? 0);
  }

  /** Index of the frame that is nearest to a time [s]. */
  frameNear(time) {
    let best = 0;
    this.frames.forEach((frame, i) => {
      if (Math.abs(frame.time - time) < Math.abs(this.frames[best].time - time)) best = i;
    });
    return best;
  }
}

/** Norms of vectors. */
function norms(vectors) {
  return Float32Array.from({ length: vectors.length / 3 }, (_, i) => Math.hypot(vectors[3 * i], vectors[3 * i + 1], vectors[3 * i + 2]));
}

/** Contacts of a message by pair, as arrays by name. */
function contactsOf(message) {
  return message.pairs.map((pair) => ({
    pair: pair.pair,
    slave: pair.slave_body,
    area: pair.patch_area_m2,
    axes: [pair.patch_long_axis_m, pair.patch_short_axis_m],
    force: pair.force_norm_n,
    ...Object.fromEntries(pair.contacts.map((array) => [array.name, unpacked(array)])),
  }));
}
