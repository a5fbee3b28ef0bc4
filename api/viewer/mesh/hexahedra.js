// Geometry of eight-node hexahedra in the order of Gmsh, Abaqus and VTK: skin, plane section, values along a line.

const FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
/** Six tetrahedra around the diagonal 0–6. */
const TETRAHEDRA = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
const EDGES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/** Corners of the box around points, x, y, z of each [m]. */
export function boxAround(points) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  points.forEach((c, i) => {
    low[i % 3] = Math.min(low[i % 3], c);
    high[i % 3] = Math.max(high[i % 3], c);
  });
  return { low, high };
}

/** Faces that belong to one element only: triangles, and the edges of the quadrilaterals, as node indices. */
export function skinOf(hexes, nodeCount) {
  const faces = new Map();
  for (let e = 0; e < hexes.length; e += 8) {
    for (const corners of FACES) {
      const face = corners.map((c) => hexes[e + c]);
      const sorted = [...face].sort((a, b) => a - b);
      // Two nodes of a face are its name but for rare twins, which the third tells apart.
      const key = `${sorted[0] * nodeCount + sorted[3]},${sorted[1]}`;
      faces.set(key, faces.has(key) ? null : face);
    }
  }
  const triangles = [];
  const edges = new Set();
  for (const face of faces.values()) {
    if (!face) continue;
    const [a, b, c, d] = face;
    triangles.push(a, b, c, a, c, d);
    face.forEach((node, i) => {
      const next = face[(i + 1) % 4];
      edges.add(Math.min(node, next) * nodeCount + Math.max(node, next));
    });
  }
  const lines = [...edges].flatMap((key) => [Math.floor(key / nodeCount), key % nodeCount]);
  return { triangles: Uint32Array.from(triangles), lines: Uint32Array.from(lines) };
}

/** The section of the elements with the plane n·x = d: triangles with a value at each corner, and the elements' outlines. */
export function planeSection({ hexes, positions, values, normal, offset }) {
  const corners = { positions: [], values: [] };
  const lines = [];
  const distance = (node) =>
    normal[0] * positions[3 * node] + normal[1] * positions[3 * node + 1] + normal[2] * positions[3 * node + 2] - offset;
  const heights = new Float64Array(8);
  for (let e = 0; e < hexes.length; e += 8) {
    let above = 0;
    for (let i = 0; i < 8; i++) above += (heights[i] = distance(hexes[e + i])) > 0 ? 1 : 0;
    if (above === 0 || above === 8) continue;
    const cross = (a, b) => {
      const share = heights[a] / (heights[a] - heights[b]);
      const [i, j] = [hexes[e + a], hexes[e + b]];
      const at = [0, 1, 2].map((k) => positions[3 * i + k] + share * (positions[3 * j + k] - positions[3 * i + k]));
      return { at, value: values ? values[i] + share * (values[j] - values[i]) : 0 };
    };
    const isCut = ([a, b]) => heights[a] > 0 !== heights[b] > 0;
    for (const tetrahedron of TETRAHEDRA) {
      const points = EDGES.map(([a, b]) => [tetrahedron[a], tetrahedron[b]]).filter(isCut).map(([a, b]) => cross(a, b));
      // Of a quadrilateral the order of the edges makes 0, 1, 3, 2 go around.
      const order = points.length === 4 ? [0, 1, 3, 0, 3, 2] : points.length === 3 ? [0, 1, 2] : [];
      for (const i of order) {
        corners.positions.push(...points[i].at);
        corners.values.push(points[i].value);
      }
    }
    for (const face of FACES) {
      const ends = face.map((c, i) => [c, face[(i + 1) % 4]]).filter(isCut).map(([a, b]) => cross(a, b).at);
      if (ends.length === 2) lines.push(...ends[0], ...ends[1]);
    }
  }
  return {
    positions: Float32Array.from(corners.positions),
    values: Float32Array.from(corners.values),
    lines: Float32Array.from(lines),
  };
}

/** Values {s, value, element} along the ray origin + s · direction, s in metres, in order: where it crosses the tetrahedra's faces. */
export function valuesAlong({ hexes, positions, values, origin, direction }) {
  const found = [];
  const point = (node) => [positions[3 * node], positions[3 * node + 1], positions[3 * node + 2]];
  for (let e = 0; e < hexes.length; e += 8) {
    const corners = Array.from({ length: 8 }, (_, i) => point(hexes[e + i]));
    if (!isNear(corners, origin, direction)) continue;
    for (const t of TETRAHEDRA) {
      for (const [a, b, c] of [[t[0], t[1], t[2]], [t[0], t[1], t[3]], [t[0], t[2], t[3]], [t[1], t[2], t[3]]]) {
        const hit = crossing(corners[a], corners[b], corners[c], origin, direction);
        if (!hit) continue;
        const [u, v] = hit.barycentric;
        const value = (1 - u - v) * values[hexes[e + a]] + u * values[hexes[e + b]] + v * values[hexes[e + c]];
        found.push({ s: hit.s, value, element: e / 8 });
      }
    }
  }
  return found.sort((a, b) => a.s - b.s);
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const crossProduct = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Whether a line comes near a few points: within their sphere. */
function isNear(corners, origin, direction) {
  const centre = [0, 1, 2].map((k) => corners.reduce((total, p) => total + p[k], 0) / corners.length);
  const radius = Math.max(...corners.map((p) => Math.hypot(...minus(p, centre))));
  return Math.hypot(...crossProduct(minus(centre, origin), direction)) <= radius * (1 + 1e-6);
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
