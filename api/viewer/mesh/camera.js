// Two cameras of one view: one in space that turns around a place, one across the section that does not.

import * as THREE from "three";
import { OrbitControls } from "../vendor/three/OrbitControls.js";

export class Cameras {
  #space = new THREE.PerspectiveCamera(35, 1, 1e-3, 100);
  #flat = new THREE.OrthographicCamera(-1, 1, 1, -1, -10, 10);
  #controls;
  #flatControls;
  #canvas;
  #halfHeight = 0.1;
  isFlat = false;
  /** Whether the reader has moved a camera. */
  isMoved = false;

  /** `onMove()` when the reader has moved the camera. */
  constructor(canvas, onMove) {
    this.#canvas = canvas;
    this.#space.up.set(0, 0, 1);
    this.#controls = this.#controlled(this.#space, onMove);
    this.#flatControls = this.#controlled(this.#flat, onMove);
    this.#flatControls.enableRotate = false;
    this.#flatControls.touches.TWO = THREE.TOUCH.DOLLY_PAN;
    this.#flatControls.mouseButtons.LEFT = THREE.MOUSE.PAN;
    this.#flatControls.enabled = false;
    // One finger scrolls the page, two turn the view: the browser must not take them for its own zoom.
    canvas.style.touchAction = "pan-y";
    const keep = (event) => event.touches.length > 1 && event.cancelable && event.preventDefault();
    for (const name of ["touchstart", "touchmove"]) canvas.addEventListener(name, keep, { passive: false });
  }

  #controlled(camera, onMove) {
    const controls = new OrbitControls(camera, this.#canvas);
    controls.zoomToCursor = true;
    // Nothing for one finger.
    controls.touches = { ONE: null, TWO: THREE.TOUCH.DOLLY_ROTATE };
    controls.listenToKeyEvents(this.#canvas);
    controls.addEventListener("change", onMove);
    controls.addEventListener("start", () => (this.isMoved = true));
    return controls;
  }

  get current() {
    return this.isFlat ? this.#flat : this.#space;
  }

  /** Looks at a sphere from a direction. */
  lookAt(centre, radius, direction) {
    this.#choose(false);
    // In a tall window the width decides.
    const narrow = Math.min(1, this.#space.aspect);
    const distance = radius / Math.sin((this.#space.fov * Math.PI) / 360) / narrow;
    this.#controls.target.fromArray(centre);
    this.#space.position.fromArray(direction).setLength(distance).add(this.#controls.target);
    this.#space.near = distance / 100;
    this.#space.far = distance * 20;
    this.#space.updateProjectionMatrix();
    this.#controls.update();
  }

  /** Looks straight at the section with a plane of this normal; `up` is up in the picture, `radius` half of its height or width. */
  lookAcross(centre, radius, normal, up) {
    this.#choose(true);
    this.#flat.up.fromArray(up);
    this.#flat.zoom = 1;
    this.#halfHeight = radius;
    this.#flatControls.target.fromArray(centre);
    this.#flat.position.fromArray(normal).setLength(1).add(this.#flatControls.target);
    this.resize(this.#space.aspect);
    this.#flat.lookAt(...centre);
  }

  #choose(isFlat) {
    this.isFlat = isFlat;
    this.#controls.enabled = !isFlat;
    this.#flatControls.enabled = isFlat;
  }

  resize(aspect) {
    this.#space.aspect = aspect;
    this.#space.updateProjectionMatrix();
    const half = this.#halfHeight / Math.min(1, aspect);
    [this.#flat.left, this.#flat.right, this.#flat.top, this.#flat.bottom] = [-half * aspect, half * aspect, half, -half];
    this.#flat.updateProjectionMatrix();
  }

  /** Takes over where another pair of cameras looks from. */
  copy(other) {
    this.#choose(other.isFlat);
    for (const [mine, its] of [[this.#space, other.#space], [this.#flat, other.#flat]]) {
      mine.position.copy(its.position);
      mine.quaternion.copy(its.quaternion);
      mine.up.copy(its.up);
      mine.zoom = its.zoom;
      mine.updateProjectionMatrix();
    }
    this.#controls.target.copy(other.#controls.target);
    this.#flatControls.target.copy(other.#flatControls.target);
  }

  dispose() {
    this.#controls.dispose();
    this.#flatControls.dispose();
  }
}
