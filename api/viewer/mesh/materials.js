// How surfaces and lines are drawn: values as colours, light from the eye, cut away beyond a plane.

import * as THREE from "three";
import { lookupTable } from "./colours.js";

const CUT = `
uniform vec4 cut;
varying vec3 place;
void clip() { if (cut.w < 1e9 && dot(cut.xyz, place) > cut.w) discard; }`;

const VERTEX = `
attribute float value;
varying float shown;
varying vec3 place;
varying vec3 toEye;
void main() {
  shown = value;
  vec4 inSpace = modelMatrix * vec4(position, 1.0);
  vec4 inView = viewMatrix * inSpace;
  place = inSpace.xyz;
  toEye = -inView.xyz;
  gl_Position = projectionMatrix * inView;
}`;

const SURFACE = `
${CUT}
uniform sampler2D map;
uniform vec2 range;
uniform vec3 plain;
uniform float isPlain;
uniform float shading;
varying float shown;
varying vec3 toEye;
void main() {
  clip();
  float fraction = clamp((shown - range.x) / (range.y - range.x), 0.0, 1.0);
  vec3 colour = mix(texture2D(map, vec2((fraction * 255.0 + 0.5) / 256.0, 0.5)).rgb, plain, isPlain);
  vec3 normal = normalize(cross(dFdx(toEye), dFdy(toEye)));
  // Light comes from the eye and a little from above; colours stay readable against the legend.
  float light = 0.62 + 0.38 * pow(abs(dot(normal, normalize(toEye + vec3(0.0, 0.35, 0.0) * length(toEye)))), 0.8);
  gl_FragColor = vec4(colour * mix(1.0, light, shading), 1.0);
}`;

const LINE = `
${CUT}
uniform vec4 colour;
void main() { clip(); gl_FragColor = colour; }`;

/** Nothing is cut beyond this. */
export const NO_CUT = new THREE.Vector4(0, 0, 0, 1e10);

/** The uniforms that all materials of one view share. */
export function sharedUniforms() {
  const texture = new THREE.DataTexture(lookupTable("cividis"), 256, 1);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return { map: { value: texture }, range: { value: new THREE.Vector2(0, 1) }, cut: { value: NO_CUT.clone() } };
}

/** A surface coloured by `value`; `plain` is its colour when it has none. */
export function surfaceMaterial(shared, { isCut = true, shading = 1 } = {}) {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: SURFACE,
    side: THREE.DoubleSide,
    // Lines on the surface lie before it.
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    uniforms: {
      map: shared.map,
      range: shared.range,
      cut: isCut ? shared.cut : { value: NO_CUT },
      plain: { value: new THREE.Color(0.72, 0.72, 0.74) },
      isPlain: { value: 0 },
      shading: { value: shading },
    },
  });
}

/** Lines of one colour [r, g, b, a]. */
export function lineMaterial(shared, colour, { isCut = true } = {}) {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: LINE,
    transparent: true,
    uniforms: { cut: isCut ? shared.cut : { value: NO_CUT }, colour: { value: new THREE.Vector4(...colour) } },
  });
}
