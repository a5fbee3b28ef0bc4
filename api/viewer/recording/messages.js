// What messages of a recording carry, as arrays.

import { Cells } from "../mesh/cells.js";
import { decompress } from "../vendor/fzstd/index.mjs";

const ARRAYS = { f32: Float32Array, f64: Float64Array, u32: Uint32Array, u8: Uint8Array };

/** A `PackedArray` as a typed array of its own: views would keep whole chunks in memory. */
export function unpacked(packed) {
  return new ARRAYS[packed.dtype](packed.data.slice().buffer);
}

/** The elements of a reference mesh: hexahedra alone, or cells with their types. */
export function cellsOf(message) {
  return message.cell_types ? new Cells(unpacked(message.cell_nodes), unpacked(message.cell_types)) : new Cells(unpacked(message.hexes));
}

/** Norms of vectors. */
export function norms(vectors) {
  const found = new Float32Array(vectors.length / 3);
  for (let i = 0; i < found.length; i++) found[i] = Math.hypot(vectors[3 * i], vectors[3 * i + 1], vectors[3 * i + 2]);
  return found;
}

/** Positions of nodes displaced by `u` from where the undeformed body with its nodes at `X` has flown in a time: X + V t + u [m]. */
export function moved(u, X, V, time) {
  const positions = u.slice();
  for (let i = 0; i < positions.length; i++) positions[i] += X[i] + V[i % 3] * time;
  return positions;
}

/** Contacts of a message by pair, as arrays by name. */
export function contactsOf(message) {
  return message.pairs.map((pair) => ({
    pair: pair.pair,
    slave: pair.slave_body,
    area: pair.patch_area_m2,
    axes: [pair.patch_long_axis_m, pair.patch_short_axis_m],
    force: pair.force_norm_n,
    ...Object.fromEntries(pair.contacts.map((array) => [array.name, unpacked(array)])),
  }));
}

export const xyz = (vector) => (vector ? [vector.x, vector.y, vector.z] : [0, 0, 0]);

/** Points and triangles of a rigid body's surface, in its axes. */
export const surfaceOf = ({ points, indices }) => ({ points: Float32Array.from(points.flatMap(xyz)), triangles: Uint32Array.from(indices) });

/** Position, and orientation as a quaternion, of a rigid body. */
export const poseOf = ({ pose: { position, orientation: q } }) => ({ position: xyz(position), orientation: [q.x, q.y, q.z, q.w] });

/** Decompresses a chunk. fzstd compares its output buffer with 1, for which JavaScript would write all of it out as text. */
export function unzstd(data, size) {
  return decompress(data, Object.assign(new Uint8Array(Number(size)), { valueOf: () => NaN }));
}
