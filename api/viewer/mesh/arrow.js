// An arrow in space, for the velocity of a body.

import * as THREE from "three";

const COLOUR = 0xa4161a;
/** Width of the shaft and of the head, and length of the head, in lengths of the arrow [-]. */
const [SHAFT, HEAD, HEAD_LENGTH] = [0.025, 0.08, 0.26];

/** An arrow `from` a place `to` another [m]. */
export function arrowBetween(from, to) {
  const [start, end] = [from, to].map((point) => new THREE.Vector3(...point));
  const length = start.distanceTo(end);
  const material = new THREE.MeshBasicMaterial({ color: COLOUR });
  const shaft = new THREE.Mesh(new THREE.CylinderGeometry(SHAFT * length, SHAFT * length, (1 - HEAD_LENGTH) * length, 12), material);
  const head = new THREE.Mesh(new THREE.ConeGeometry(HEAD * length, HEAD_LENGTH * length, 20), material);
  shaft.position.y = 0.5 * (1 - HEAD_LENGTH) * length;
  head.position.y = (1 - 0.5 * HEAD_LENGTH) * length;
  const arrow = new THREE.Group();
  arrow.add(shaft, head);
  arrow.position.copy(start);
  // Both are made along y.
  arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), end.sub(start).normalize());
  return arrow;
}
