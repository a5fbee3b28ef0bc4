// Geometry of cells of mixed kinds: their surface, and which of them a plane meets.

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
  for (let i = 0, k = 0; i < points.length; i++, k = k === 2 ? 0 : k + 1) {
    if (points[i] < low[k]) low[k] = points[i];
    if (points[i] > high[k]) high[k] = points[i];
  }
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
  const sides = sidesOf(cells);
  const kinds = kindsOfSides(cells, sides, nodeCount, partOf, eroded);
  const [triangles, elements, lines] = [[], [], []];
  // Edges, chained by their lower node.
  const [head, next, highs] = [new Int32Array(nodeCount).fill(-1), [], []];
  const addEdge = (low, high) => {
    let edge = head[low];
    while (edge >= 0 && highs[edge] !== high) edge = next[edge];
    if (edge >= 0) return;
    next.push(head[low]);
    head[low] = highs.push(high) - 1;
    lines.push(low, high);
  };
  for (let side = 0; side < kinds.length; side++) {
    if (kinds[side] !== SIDE.surface) continue;
    const face = sides.nodesOf(side);
    for (const [a, b, c] of TRIANGLES[face.length]) {
      triangles.push(face[a], face[b], face[c]);
      elements.push(sides.elements[side]);
    }
    for (let i = 0; i < face.length; i++) {
      const [node, other] = [face[i], face[(i + 1) % face.length]];
      addEdge(Math.min(node, other), Math.max(node, other));
    }
  }
  return { triangles: new Uint32Array(triangles), lines: new Uint32Array(lines), elements: new Uint32Array(elements), sides: kinds };
}

/** The sides of all elements, one element after the other: `elements` they belong to, `nodesOf(side)` around them. */
function sidesOf(cells) {
  const first = new Uint32Array(cells.length + 1);
  for (let e = 0; e < cells.length; e++) first[e + 1] = first[e] + cells.kindOf(e).sides.length;
  const elements = new Uint32Array(first[cells.length]);
  for (let e = 0; e < cells.length; e++) elements.fill(e, first[e], first[e + 1]);
  const nodesOf = (side) => {
    const [element, nodes] = [elements[side], cells.nodes];
    const start = cells.startOf(element);
    return cells.kindOf(element).sides[side - first[element]].map((i) => nodes[start + i]);
  };
  return { elements, nodesOf };
}

/** What each side of each element is. Sides are chained by their lowest node; three nodes of a side are its name but for rare twins. */
function kindsOfSides(cells, sides, nodeCount, partOf, eroded) {
  const [{ nodes }, { elements }] = [cells, sides];
  const count = elements.length;
  const kinds = new Uint8Array(count);
  const [head, next] = [new Int32Array(nodeCount).fill(-1), new Int32Array(count)];
  const [middles, highs] = [new Uint32Array(count), new Uint32Array(count)];
  for (let e = 0, side = 0; e < cells.length; e++) {
    const [start, faces] = [cells.startOf(e), cells.kindOf(e).sides];
    const isGone = eroded?.[e];
    for (let s = 0; s < faces.length; s++, side++) {
      if (isGone) continue;
      const corners = faces[s];
      let [low, middle, high] = [MOST_NODES, MOST_NODES, -1];
      for (let i = 0; i < corners.length; i++) {
        const node = nodes[start + corners[i]];
        if (node < low) {
          middle = low;
          low = node;
        } else if (node < middle) middle = node;
        if (node > high) high = node;
      }
      // The same side of a neighbour, or else one that may be on the surface.
      let other = head[low];
      while (other >= 0 && (middles[other] !== middle || highs[other] !== high)) other = next[other];
      if (other >= 0) {
        kinds[side] = kinds[other] = partOf && partOf[elements[other]] !== partOf[e] ? SIDE.interface : SIDE.inside;
        continue;
      }
      next[side] = head[low];
      head[low] = side;
      middles[side] = middle;
      highs[side] = high;
      kinds[side] = SIDE.surface;
    }
  }
  joinHanging(sides, kinds, partOf, { head, next, highs });
  return kinds;
}

/** A number above those of all nodes. */
const MOST_NODES = 2 ** 26;

/**
 * Joins sides of four nodes with the four smaller ones on their other side, which have a node in its middle: hexahedra of two sizes.
 * `chains` are those of the sides by their lowest node.
 */
function joinHanging({ elements, nodesOf }, kinds, partOf, { head, next, highs }) {
  // Of the sides around a node, if they are four: themselves, and their nodes opposite to it.
  const [counts, around, opposite] = [new Uint8Array(head.length), new Int32Array(4 * head.length), new Uint32Array(4 * head.length)];
  for (let side = 0; side < kinds.length; side++) {
    if (kinds[side] !== SIDE.surface) continue;
    const nodes = nodesOf(side);
    if (nodes.length !== 4) continue;
    for (let i = 0; i < 4; i++) {
      const place = 4 * nodes[i] + counts[nodes[i]];
      if (counts[nodes[i]]++ >= 4) counts[nodes[i]] = 5;
      else [around[place], opposite[place]] = [side, nodes[(i + 2) % 4]];
    }
  }
  for (let middle = 0; middle < counts.length; middle++) {
    if (counts[middle] !== 4) continue;
    const corners = opposite.subarray(4 * middle, 4 * middle + 4);
    const most = Math.max(corners[0], corners[1], corners[2], corners[3]);
    let large = head[Math.min(corners[0], corners[1], corners[2], corners[3])];
    while (large >= 0 && (highs[large] !== most || kinds[large] !== SIDE.surface || !corners.every((node) => nodesOf(large).includes(node)))) large = next[large];
    if (large < 0 || nodesOf(large).includes(middle)) continue;
    const small = around.subarray(4 * middle, 4 * middle + 4);
    const isWithin = (side) => !partOf || partOf[elements[side]] === partOf[elements[large]];
    for (const side of small) kinds[side] = isWithin(side) ? SIDE.inside : SIDE.interface;
    kinds[large] = small.every(isWithin) ? SIDE.inside : SIDE.interface;
  }
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
