// Renderers of meshes. One can be made ready before there is anything to draw: setting it up takes as long as a recording takes to come.

import * as THREE from "three";
import { lineMaterial, sharedUniforms, surfaceMaterial } from "./materials.js";

const BACKGROUND = 0xf4f6f8;
/** What programs that draw without a graphics card call themselves. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

let ready = null;

/** Makes a renderer ready, with its programs, for the next view that asks for one. */
export function prepareRenderer() {
  ready ??= withPrograms(newRenderer());
}

/** The renderer that is ready, or a new one. */
export function takeRenderer() {
  const renderer = ready ?? newRenderer();
  ready = null;
  return renderer;
}

/** A renderer; without a graphics card one without smooth edges, which take half of the time of a picture there. */
function newRenderer() {
  const plain = new THREE.WebGLRenderer();
  const gl = plain.getContext();
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const isSoftware = info && SOFTWARE.test(gl.getParameter(info.UNMASKED_RENDERER_WEBGL));
  if (!isSoftware) {
    plain.dispose();
    plain.forceContextLoss();
  }
  const renderer = isSoftware ? plain : new THREE.WebGLRenderer({ antialias: true });
  renderer.setClearColor(BACKGROUND);
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  return renderer;
}

/** Draws a triangle with each material that bodies have, so that their programs are there. They stay as long as the renderer. */
function withPrograms(renderer) {
  const [shared, black] = [sharedUniforms(), [0, 0, 0]];
  const surfaces = [{}, { isCut: false }, { isFilled: true }].map((options) => surfaceMaterial(shared, black, options));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]), 3));
  geometry.setAttribute("value", new THREE.BufferAttribute(new Float32Array(3), 1));
  const scene = new THREE.Scene();
  scene.add(...surfaces.map((material) => new THREE.Mesh(geometry, material)), new THREE.LineSegments(geometry, lineMaterial(shared, [...black, 0])));
  renderer.setSize(8, 8, false);
  renderer.render(scene, new THREE.OrthographicCamera());
  geometry.dispose();
  return renderer;
}
