// The touching points of a contact pair in the plane across their mean normal.

export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const scaled = (a) => a.map((c) => c / (Math.hypot(...a) || 1));

/**
 * Touching points of one pair [m], with what they carry [N]: {points, normal, centre, axes}, `axes` the two directions of the plane; null
 * when nothing touches.
 */
export function flatPatch(contacts) {
  const count = contacts?.node?.length ?? 0;
  if (!count) return null;
  const at = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];
  const normal = scaled([0, 1, 2].map((k) => contacts.normal.reduce((total, c, i) => (i % 3 === k ? total + c : total), 0)));
  const total = contacts.normal_force_n.reduce((a, b) => a + b, 0);
  const weight = (f) => (total > 0 ? f / total : 1 / count);
  const centre = [0, 1, 2].map((k) => contacts.normal_force_n.reduce((sum, f, i) => sum + weight(f) * contacts.position_m[3 * i + k], 0));
  const least = normal.map(Math.abs).indexOf(Math.min(...normal.map(Math.abs)));
  const first = scaled(cross(normal, [0, 1, 2].map((k) => (k === least ? 1 : 0))));
  const second = cross(normal, first);
  const points = Array.from({ length: count }, (_, i) => {
    const position = at(contacts.position_m, i);
    const arm = position.map((c, k) => c - centre[k]);
    return { x: dot(arm, first), y: dot(arm, second), node: contacts.node[i], force: contacts.normal_force_n[i], isSticking: contacts.status[i] === 1 };
  });
  return { points, normal, centre, axes: [first, second] };
}
