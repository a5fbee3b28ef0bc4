// A recording, read once from the beginning to the end through its index: what the page shows of it.

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

/** The elements of a reference mesh: hexahedra alone, or cells with their types. */
function cellsOf(message) {
  return message.cell_types ? new Cells(unpacked(message.cell_nodes), unpacked(message.cell_types)) : new Cells(unpacked(message.hexes));
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

  /**
   * Opens the recording at an address and reads all of it. On the way `onProgress(fraction)`, and once `onFirst(recording)`, as soon as
   * its first frame is complete.
   */
  static async open(path, { onProgress = () => {}, onFirst = () => {} } = {}) {
    const source = new HttpRange(path);
    const decompressHandlers = { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) };
    const reader = await McapIndexedReader.Initialize({ readable: source, decompressHandlers });
    const recording = new Recording();
    recording.bytes = Number(await source.size());
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
    await recording.#readMessages(reader, onProgress, onFirst);
    return recording;
  }

  /** The scene document that the recording at an address carries, as text. */
  static async sceneText(path) {
    const reader = await McapIndexedReader.Initialize({ readable: new HttpRange(path), decompressHandlers: {} });
    for await (const attachment of reader.readAttachments({ name: "scene.json" })) {
      return new TextDecoder().decode(attachment.data);
    }
    throw new Error("The recording carries no scene.");
  }

  async #readMessages(reader, onProgress, onFirst) {
    const decoders = new Map();
    const channels = new Map();
    for (const [id, channel] of reader.channelsById) {
      const schema = reader.schemasById.get(channel.schemaId);
      if (!decoders.has(schema.name)) decoders.set(schema.name, decoderOf(schema.name, schema.data));
      channels.set(id, { topic: channel.topic, decode: decoders.get(schema.name) });
    }
    const erodes = this.scene?.bodies?.some((body) => body.parts?.some((part) => part.erosion));
    const topics = [...channels.values()].map((c) => c.topic).filter((t) => erodes || !t.startsWith("/stress/"));
    this.topics = [...channels.values()].map((c) => c.topic);
    const count = Number(reader.statistics?.messageCount ?? 0n);
    let [seen, isSeen] = [0, false];
    for await (const message of reader.readMessages({ topics })) {
      const { topic, decode } = channels.get(message.channelId);
      this.#take(topic, () => decode(message.data), message.publishTime);
      if (!isSeen && this.frames.length > 1) {
        isSeen = true;
        onFirst(this);
      }
      if (++seen % 200 === 0) {
        onProgress(count ? Math.min(seen / count, 1) : 0);
        // The page goes on answering.
        await new Promise((resolve) => setTimeout(resolve));
      }
    }
    this.frames = this.frames.filter((frame, i) => i % this.stride === 0 || i === this.frames.length - 1);
    onProgress(1);
  }

  /** Takes in one message; decodes it only if it is of use. */
  #take(topic, decoded, at) {
    const [, kind] = topic.split("/");
    if (topic === "/energy") this.series.takeEnergy(decoded());
    else if (topic === "/contact/forces") {
      const message = decoded();
      this.series.takeForces(message);
      this.#latestContacts = { at, message };
    } else if (kind === "reference") this.#takeReference(topic.slice("/reference/".length), decoded());
    else if (kind === "pose") this.#latestPoses.set(topic.slice("/pose/".length), { at, message: decoded() });
    else if (kind === "stress") this.#takeEroded(topic.slice("/stress/".length), decoded());
    else if (kind === "points") this.#takePoints(topic.slice("/points/".length), decoded(), at);
    else if (kind === "mesh" && !this.#names.has(topic.slice("/mesh/".length))) {
      this.#takeRigidMesh(topic.slice("/mesh/".length), decoded(), at);
    } else if (topic === "/summary") this.latestSummary = JSON.parse(decoded().json);
  }

  /** Names of bodies by their part of the topic. */
  #names = new Map();
  #latestContacts = null;
  #latestPoses = new Map();
  /** Elements that are gone (1) or not (0), by part of the topic; the same array as long as none are added. */
  #eroded = new Map();
  #bytesOfFrames = 0;

  #takeReference(topicName, message) {
    const V = xyz(message.flight_velocity_m_per_s);
    const body = { name: message.body, role: message.role, parts: message.parts, V };
    body.X = unpacked(message.positions);
    body.cells = cellsOf(message);
    body.partOf = unpacked(message.part_of);
    this.bodies.set(body.name, body);
    this.#names.set(topicName, body.name);
  }

  /** The frame of this moment, made when it is the first message of it. */
  #frameAt(at, time) {
    let frame = this.frames.at(-1);
    if (frame?.at !== at) {
      frame = { at, time, bodies: new Map(), contacts: null };
      if (this.#latestContacts?.at === at) frame.contacts = contactsOf(this.#latestContacts.message);
      this.frames.push(frame);
      this.#keepWithinBudget();
    }
    return frame;
  }

  /** Lets the fields of frames between the kept ones go. */
  #keepWithinBudget() {
    if (this.#bytesOfFrames < FRAME_BUDGET) return;
    this.stride *= 2;
    this.frames = this.frames.filter((_, i) => i % 2 === 0);
    this.#bytesOfFrames /= 2;
  }

  #takeEroded(topicName, { element }) {
    const found = element.find((array) => array.name === "eroded");
    const eroded = found && unpacked(found);
    const known = this.#eroded.get(topicName);
    if (eroded?.some((gone, e) => gone !== (known?.[e] ?? 0))) this.#eroded.set(topicName, eroded);
  }

  #takePoints(topicName, cloud, at) {
    const name = this.#names.get(topicName);
    const frame = this.#frameAt(at, Number(at) * 1e-9);
    const stride = cloud.point_stride / 4;
    const rows = new Float32Array(cloud.data.slice().buffer);
    const count = rows.length / stride;
    const fields = {};
    const positions = new Float32Array(3 * count);
    for (let i = 0; i < count; i++) positions.set(rows.subarray(i * stride, i * stride + 3), 3 * i);
    cloud.fields.slice(3).forEach((field) => {
      const column = field.offset / 4;
      fields[field.name] = Float32Array.from({ length: count }, (_, i) => rows[i * stride + column]);
    });
    fields.displacement_m ??= displacement(this.bodies.get(name), positions, frame.time);
    frame.bodies.set(name, { positions, fields, eroded: this.#eroded.get(topicName) ?? null });
    this.#bytesOfFrames += 4 * count * (3 + Object.keys(fields).length);
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

/** Norm of u = x − X − V t at the nodes [m]. */
function displacement({ X, V }, x, time) {
  return Float32Array.from({ length: x.length / 3 }, (_, i) =>
    Math.hypot(...V.map((v, k) => x[3 * i + k] - X[3 * i + k] - v * time)),
  );
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
