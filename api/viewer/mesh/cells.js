// Geometry of cells of mixed kinds: surface, values along a line.

/** Kinds by VTK's cell type, nodes in the order of VTK: sides seen from outside, with all nodes around them, and tetrahedra that fill them. */
const KINDS = new Map([
  [10, { nodes: 4, sides: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], tetrahedra: [[0, 1, 2, 3]] }],
  [12, {
    nodes: 8,
    sides: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    // Around the diagonal 0–6.
    tetrahedra: [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]],
  }],
  [13, {
    nodes: 6,
    sides: [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
    tetrahedra: [[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]],
  }],
  [24, {
    nodes: 10,
    sides: [[0, 6, 2, 5, 1, 4], [0, 4, 1, 8, 3, 7], [1, 5, 2, 9, 3, 8], [0, 7, 3, 9, 2, 6]],
    tetrahedra: [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3], [4, 6, 7, 8], [5, 6, 4, 8], [6, 7, 8, 9], [8, 5, 6, 9]],
  }],
]);
const HEXAHEDRON = 12;
/** Triangles that fill a side, by the number of its nodes: of six every second one is the middle of an edge. */
const TRIANGLES = { 3: [[0, 1, 2]], 4: [[0, 1, 2], [0, 2, 3]], 6: [[0, 1, 5], [1, 2, 3], [3, 4, 5], [1, 3, 5]] };

/** The elements of a body in their order. */
export class Cells {
  /** The nodes of all of them, one element after the other. */
  nodes;
  #types;
  #starts;

  /** Of `hexes`, eight nodes each; or of `nodes` with VTK's cell type of each element. */
  constructor(nodes, types = null) {
    this.nodes = nodes;
    this.#types = types;
    if (!types) return;
    this.#starts = new Uint32Array(types.length);
    let start = 0;
    types.forEach((type, e) => {
      if (!KINDS.has(type)) throw new Error(`The recording has elements of VTK's type ${type}, which are not supported.`);
      this.#starts[e] = start;
      start += KINDS.get(type).nodes;
    });
  }

  get length() {
    return this.#types ? this.#types.length : this.nodes.length / 8;
  }

  /** Place in `nodes` where an element begins. */
  startOf(element) {
    return this.#types ? this.#starts[element] : 8 * element;
  }

  /** Number of nodes, sides and tetrahedra of an element. */
  kindOf(element) {
    return KINDS.get(this.#types ? this.#types[element] : HEXAHEDRON);
  }

  /** The nodes of an element. */
  nodesOf(element) {
    const start = this.startOf(element);
    return this.nodes.subarray(start, start + this.kindOf(element).nodes);
  }

  /** Whether another body has the same elements. */
  equals(other) {
    return (
      other.length === this.length &&
      other.nodes.length === this.nodes.length &&
      other.nodes.every((node, i) => node === this.nodes[i]) &&
      Array.from({ length: this.length }, (_, e) => e).every((e) => other.kindOf(e) === this.kindOf(e))
    );
  }
}

/** Corners of the box around points, x, y, z of each [m]. */
export function boxAround(points) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  points.forEach((c, i) => {
    low[i % 3] = Math.min(low[i % 3], c);
    high[i % 3] = Math.max(high[i % 3], c);
  });
  return { low, high };
}

/** What a side of an element is: within a part, between two parts, or on the surface of the body. */
export const SIDE = { inside: 0, interface: 1, surface: 2 };

/** Surfaces by the array of the eroded elements, or by the body where none are. */
const surfaces = new WeakMap();

/**
 * The surface of a body {X, cells, partOf} without its `eroded` elements: `triangles` and `lines` (the edges of the faces) as node indices,
 * `elements` of the triangles, and `sides`: what each side of each element is, element after element.
 */
export function surfaceOf(body, eroded = null) {
  const key = eroded ?? body;
  if (!surfaces.has(key)) surfaces.set(key, findSurface(body, eroded));
  return surfaces.get(key);
}

function findSurface({ X, cells, partOf = null }, eroded) {
  const nodeCount = X.length / 3;
  const kinds = kindsOfSides(cells, nodeCount, partOf, eroded);
  const [triangles, elements] = [[], []];
  const edges = new Set();
  let side = 0;
  for (let e = 0; e < cells.length; e++) {
    const start = cells.startOf(e);
    for (const corners of cells.kindOf(e).sides) {
      if (kinds[side++] !== SIDE.surface) continue;
      const face = corners.map((i) => cells.nodes[start + i]);
      for (const triangle of TRIANGLES[face.length]) {
        triangles.push(...triangle.map((i) => face[i]));
        elements.push(e);
      }
      face.forEach((node, i) => {
        const next = face[(i + 1) % face.length];
        edges.add(Math.min(node, next) * nodeCount + Math.max(node, next));
      });
    }
  }
  const lines = new Uint32Array(2 * edges.size);
  let at = 0;
  for (const key of edges) {
    lines[at++] = Math.floor(key / nodeCount);
    lines[at++] = key % nodeCount;
  }
  return { triangles: new Uint32Array(triangles), lines, elements: new Uint32Array(elements), sides: kinds };
}

/** What each side of each element is. Sides are chained by their lowest node; three nodes of a side are its name but for rare twins. */
function kindsOfSides(cells, nodeCount, partOf, eroded) {
  let count = 0;
  for (let e = 0; e < cells.length; e++) count += cells.kindOf(e).sides.length;
  const kinds = new Uint8Array(count);
  const [head, next] = [new Int32Array(nodeCount).fill(-1), new Int32Array(count)];
  const [middles, highs, elementOf] = [new Uint32Array(count), new Uint32Array(count), new Uint32Array(count)];
  let side = -1;
  for (let e = 0; e < cells.length; e++) {
    const start = cells.startOf(e);
    for (const corners of cells.kindOf(e).sides) {
      side++;
      if (eroded?.[e]) continue;
      let [low, middle, high] = [Infinity, Infinity, -1];
      for (const i of corners) {
        const node = cells.nodes[start + i];
        if (node < low) [low, middle] = [node, low];
        else if (node < middle) middle = node;
        if (node > high) high = node;
      }
      // The same side of a neighbour, or else one that may be on the surface.
      let other = head[low];
      while (other >= 0 && (middles[other] !== middle || highs[other] !== high)) other = next[other];
      if (other >= 0) {
        kinds[side] = kinds[other] = partOf && partOf[elementOf[other]] !== partOf[e] ? SIDE.interface : SIDE.inside;
      } else {
        [next[side], head[low], middles[side], highs[side], elementOf[side], kinds[side]] = [head[low], side, middle, high, e, SIDE.surface];
      }
    }
  }
  joinHanging(cells, kinds, partOf);
  return kinds;
}

/** A number above those of all nodes, with which two of them are one exact number. */
const MOST_NODES = 2 ** 26;

/** Joins sides of four nodes with the four smaller ones on their other side, which have a node in its middle: hexahedra of two sizes. */
function joinHanging(cells, kinds, partOf) {
  const [open, around] = [new Map(), new Map()];
  const put = (map, key, face) => (map.has(key) ? map.get(key).push(face) : map.set(key, [face]));
  const name = (nodes) => Math.min(...nodes) * MOST_NODES + Math.max(...nodes);
  let side = -1;
  for (let element = 0; element < cells.length; element++) {
    const start = cells.startOf(element);
    for (const corners of cells.kindOf(element).sides) {
      side++;
      if (kinds[side] !== SIDE.surface || corners.length !== 4) continue;
      const face = { side, element, nodes: corners.map((i) => cells.nodes[start + i]) };
      put(open, name(face.nodes), face);
      for (const node of face.nodes) put(around, node, face);
    }
  }
  for (const [middle, small] of around) {
    if (small.length !== 4) continue;
    const corners = small.map(({ nodes }) => nodes[(nodes.indexOf(middle) + 2) % 4]);
    const large = open.get(name(corners))?.find(({ nodes }) => corners.every((node) => nodes.includes(node)));
    if (!large || large.nodes.includes(middle)) continue;
    const isWithin = ({ element }) => !partOf || partOf[element] === partOf[large.element];
    for (const face of small) kinds[face.side] = isWithin(face) ? SIDE.inside : SIDE.interface;
    kinds[large.side] = small.every(isWithin) ? SIDE.inside : SIDE.interface;
  }
}

/** Values {s, value, element} along the ray origin + s · direction, s in metres, in order: where it crosses the tetrahedra's faces. */
export function valuesAlong({ cells, positions, values, origin, direction, eroded = null }) {
  const found = [];
  const point = (node) => [positions[3 * node], positions[3 * node + 1], positions[3 * node + 2]];
  const across = acrossLine(positions, origin, direction);
  for (let element = 0; element < cells.length; element++) {
    if (eroded?.[element] || !across.every((distances) => areAround(distances, cells, element))) continue;
    const nodes = cells.nodesOf(element);
    const corners = Array.from(nodes, point);
    for (const t of cells.kindOf(element).tetrahedra) {
      for (const [a, b, c] of [[t[0], t[1], t[2]], [t[0], t[1], t[3]], [t[0], t[2], t[3]], [t[1], t[2], t[3]]]) {
        const hit = crossing(corners[a], corners[b], corners[c], origin, direction);
        if (!hit) continue;
        const [u, v] = hit.barycentric;
        const value = (1 - u - v) * values[nodes[a]] + u * values[nodes[b]] + v * values[nodes[c]];
        found.push({ s: hit.s, value, element });
      }
    }
  }
  return found.sort((a, b) => a.s - b.s);
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const crossProduct = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Distances of points from a line in two directions across it, as two arrays. */
function acrossLine(positions, origin, direction) {
  const sizes = direction.map(Math.abs);
  const least = sizes.indexOf(Math.min(...sizes));
  const first = crossProduct(direction, [0, 1, 2].map((k) => Number(k === least)));
  return [first, crossProduct(direction, first)].map((axis) => distancesAlong(positions, axis, dot(axis, origin)));
}

/** Distances n·x − d of points from a plane. */
export function distancesAlong(positions, [nx, ny, nz], offset) {
  const distances = new Float64Array(positions.length / 3);
  for (let i = 0; i < distances.length; i++) distances[i] = nx * positions[3 * i] + ny * positions[3 * i + 1] + nz * positions[3 * i + 2] - offset;
  return distances;
}

/** Whether the nodes of an element are on both sides of a plane, or nearly. */
export function areAround(distances, cells, element) {
  const [start, { nodes: count }] = [cells.startOf(element), cells.kindOf(element)];
  let [low, high] = [Infinity, -Infinity];
  for (let i = start; i < start + count; i++) {
    const distance = distances[cells.nodes[i]];
    if (distance < low) low = distance;
    if (distance > high) high = distance;
  }
  const slack = 1e-5 * (high - low);
  return low <= slack && high >= -slack;
}

/** Where a ray crosses a triangle (Möller and Trumbore 1997); edges count as inside. */
function crossing(a, b, c, origin, direction) {
  const [ab, ac] = [minus(b, a), minus(c, a)];
  const p = crossProduct(direction, ac);
  const determinant = dot(ab, p);
  if (Math.abs(determinant) < 1e-18) return null;
  const t = minus(origin, a);
  const u = dot(t, p) / determinant;
  const q = crossProduct(t, ab);
  const v = dot(direction, q) / determinant;
  const slack = 1e-6;
  if (u < -slack || v < -slack || u + v > 1 + slack) return null;
  return { s: dot(ac, q) / determinant, barycentric: [u, v] };
}
