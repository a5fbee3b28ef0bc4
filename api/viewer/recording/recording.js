// A recording, read through its index: first the frame that is shown first, then everything from the beginning to the end, and before
// the rest of it what is asked for.

import { McapIndexedReader } from "../vendor/mcap/McapIndexedReader.js";
import { boneOf } from "../mesh/bone.js";
import { HttpRange } from "./http_range.js";
import { cellsOf, contactsOf, moved, norms, poseOf, surfaceOf, unpacked, unzstd, xyz } from "./messages.js";
import { decoderOf } from "./protobuf.js";
import { Series } from "./series.js";

/** Frames in memory may take so much [bytes]; of longer recordings every second one is read, or fewer. */
const FRAME_BUDGET = 512 << 20;
/** While it reads, the page answers after so long [ms]. */
const PAUSE_AFTER = 30;

/** Log times of the messages of one step follow each other by nanoseconds, fewer than this. */
const NANOSECONDS_OF_STEP = 100_000n;

/** A time [s] as messages carry it [ns]: 0 before the start. */
const nanoseconds = (time) => BigInt(Math.round(Math.max(time, 0) * 1e9));

/** What is said of recordings whose positions are elsewhere. */
const TOO_OLD = "An earlier version of Contuse made this recording: its fields have no displacements. Run its scene again to see them.";

/** Waits until the browser has shown what was drawn; a hidden page shows nothing. */
function pictureShown() {
  if (document.hidden) return Promise.resolve();
  return new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
}

export class Recording {
  /** Metadata of the run and of its end, by name of the record. */
  run = {};
  ending = {};
  /** Bodies: name, role, and `X` [m], `cells` (deformable) or `surface` {points, triangles} (rigid). */
  bodies = new Map();
  /** States at the field times: `time` [s], `bodies` by name ({positions, fields, eroded} or {pose}), `contacts` by pair. */
  frames = [];
  series = new Series();
  /** Every how many field times there is a frame. */
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
    recording.#times = new Map(recording.#fieldTimes().map((time) => [nanoseconds(time), time]));
    for await (const message of recording.#messages(["reference"])) recording.#take(message);
    return recording;
  }

  /**
   * Reads all of it. Of its frames the one nearest to the time `first` [s] is fetched before the others: as soon as it is there
   * `onFirst()` is called, then, while the others come, `onProgress(fraction)`. Frames that `has` is asked for come next.
   */
  async read({ first = 0, onProgress = () => {}, onFirst = () => {} } = {}) {
    const [nearest] = this.times.sort((a, b) => Math.abs(a - first) - Math.abs(b - first));
    if (nearest != null) await this.#readAlone(nearest);
    if (this.frames.length) {
      this.#fitIntoMemory();
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

  /** The times of the frames, read or not [s]. */
  get times() {
    return [...this.#times.values()];
  }

  /** Whether the frames around a time [s] are there; those that are not are read next. */
  has(time) {
    const { times } = this;
    const around = times.filter((t, i) => t === time || (t < time && times[i + 1] > time) || (t > time && times[i - 1] < time));
    this.#wanted = around.filter((t) => !this.frames.some((frame) => frame.time === t && frame.isWhole));
    return !this.#wanted.length;
  }

  /** The field times up to where the recording goes, and where the run ended [s]; none if nothing is recorded in space. */
  #fieldTimes() {
    if (![...this.#channels.values()].some(({ kind }) => kind === "stress" || kind === "mesh")) return [];
    const last = this.#reader.chunkIndexes.reduce((most, { messageEndTime }) => (messageEndTime > most ? messageEndTime : most), 0n);
    const end = this.ending.time_s == null ? [] : [Number(this.ending.time_s)];
    const times = JSON.parse(this.run.field_times_s).filter((time) => this.#logTime(time) <= last && !(time >= end[0]));
    return [...times, ...end];
  }

  /** A log time just before the messages of a simulated time [s]. */
  #logTime(time) {
    return BigInt(Math.max(0, Math.floor(time * Number(this.run.time_factor) * 1e9) - 1));
  }

  /** Reads the fields, contacts and poses of one field time. */
  async #readAlone(time) {
    const startTime = this.#logTime(time);
    const range = { startTime, endTime: startTime + NANOSECONDS_OF_STEP };
    for await (const message of this.#messages(["contact", "pose", "mesh", "stress"], range)) this.#take(message, { isAlone: true });
    this.#endFrame(nanoseconds(time));
  }

  async #readAll(onProgress) {
    const counts = this.#reader.statistics?.channelMessageCounts ?? new Map();
    const count = [...this.#channels.keys()].reduce((sum, id) => sum + Number(counts.get(id) ?? 0n), 0);
    const kinds = new Set([...this.#channels.values()].map(({ kind }) => kind));
    kinds.delete("reference");
    let [seen, at, paused] = [0, null, performance.now()];
    for await (const message of this.#messages([...kinds])) {
      if (message.publishTime !== at) this.#endFrame(at);
      at = message.publishTime;
      this.#take(message);
      seen += 1;
      if (performance.now() - paused > PAUSE_AFTER) {
        for (const time of this.#wanted.splice(0)) await this.#readAlone(time);
        onProgress(count ? Math.min(seen / count, 1) : 0);
        await new Promise((resolve) => setTimeout(resolve));
        paused = performance.now();
      }
    }
    this.#endFrame(at);
    this.#times = new Map(this.frames.map((frame) => [frame.at, frame.time]));
    onProgress(1);
  }

  /** Takes in one message; one that `isAlone` is no part of the curves. */
  #take({ channelId, data, publishTime: at }, { isAlone = false } = {}) {
    const { kind, name, decode } = this.#channels.get(channelId);
    const isOfFrame = kind === "stress" || kind === "mesh";
    if (isOfFrame && (!this.#times.has(at) || this.#frameAt(at).isWhole)) return;
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
  /** Simulated times of the frames [s], by those of their messages [ns]. */
  #times;
  #wanted = [];
  /** Names of bodies by their part of the topic. */
  #names = new Map();
  #latestContacts = null;
  #latestPoses = new Map();
  /** Elements that are gone (1) or not (0), by part of the topic; the same array as long as none are added. */
  #eroded = new Map();

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
  #frameAt(at) {
    const next = this.frames.findLastIndex((frame) => frame.at < at) + 1;
    if (this.frames[next]?.at === at) return this.frames[next];
    const frame = { at, time: this.#times.get(at), bodies: new Map(), contacts: null, isWhole: false };
    if (this.#latestContacts?.at === at) frame.contacts = contactsOf(this.#latestContacts.message);
    this.frames.splice(next, 0, frame);
    return frame;
  }

  /** All of the frame of this moment, if there is one, has been taken in. */
  #endFrame(at) {
    const frame = this.frames.find((one) => one.at === at);
    if (frame) frame.isWhole = true;
  }

  /** Omits frames, if all would be too large; each is as large as the first that was read. */
  #fitIntoMemory() {
    const [{ at, bodies }] = this.frames;
    const sizes = [...bodies.values()].flatMap(({ positions, fields }) => [positions, ...Object.values(fields ?? {})]);
    const size = sizes.reduce((sum, array) => sum + (array?.byteLength ?? 0), 0);
    this.stride = Math.max(1, Math.ceil((size * this.#times.size) / FRAME_BUDGET));
    const last = this.#times.size - 1;
    this.#times = new Map([...this.#times].filter(([key], i) => i % this.stride === 0 || i === last || key === at));
  }

  #takeFields(topicName, { nodal, element, time_s }, at) {
    const { name, X, V } = this.bodies.get(this.#names.get(topicName));
    const arrays = new Map(nodal.map((array) => [array.name, unpacked(array)]));
    const u = arrays.get("displacement_m");
    if (!u) throw new Error(TOO_OLD);
    const positions = moved(u, X, V, Math.max(time_s, 0));
    const fields = Object.fromEntries(nodal.map((array) => [array.name, array.components === 3 ? norms(arrays.get(array.name)) : arrays.get(array.name)]));
    this.#frameAt(at).bodies.set(name, { positions, fields, eroded: this.#erodedOf(topicName, element) });
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
      const role = this.#latestPoses.get(topicName)?.message.role ?? "other";
      this.bodies.set(entity.id, { name: entity.id, role, surface: surfaceOf(mesh) });
    }
    this.#frameAt(at).bodies.set(entity.id, { pose: poseOf(mesh) });
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
