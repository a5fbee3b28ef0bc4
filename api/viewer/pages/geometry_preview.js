// The geometry of a scene before anything runs: a section through the projectile and the target, to scale, drawn from the document and
// the sections of uploaded meshes.

import { html, svg } from "../dom.js";
import { niceAbove, setting } from "../format.js";
import { COLOURS, colourOfPart } from "../mesh/part_colours.js";
import { Sections, cropOf, outlinesOf, uploadedIn } from "../scene/uploaded.js";

const [WIDTH, HEIGHT, EDGE] = [460, 300, 14];
/** Names beside the picture: the width that is left for them, their number and their length. */
const [NAMES, MOST_NAMES, LONGEST_NAME] = [160, 16, 14];

const sum = (a, b) => a.map((c, k) => c + (b[k] ?? 0));
const number = (value) => typeof value === "number" && Number.isFinite(value);
const at = (vector) => (Array.isArray(vector) && vector.length === 3 && vector.every(number) ? vector : [0, 0, 0]);

/** An ellipse in the plane of z and another axis [m], which is x below: y (`across` 1) where a projectile flies along it. */
const ellipse = (name, centre, across, a, c = a) => ({ kind: "ellipse", name, x: centre[across], z: centre[2], a, c });
const box = (name, [x0, z0], [x1, z1]) => ({ kind: "box", name, x: (x0 + x1) / 2, z: (z0 + z1) / 2, a: (x1 - x0) / 2, c: (z1 - z0) / 2 });

/** The shapes of a generated mesh, the outer ones first. */
function ofGenerator(generator, moved, name, across) {
  const centre = sum(at(generator.center_m), moved);
  const inPlane = (point) => [point[across], point[2]];
  switch (generator.kind) {
    case "hollow_ball": return [ellipse(name, centre, across, generator.outer_radius_m), ellipse("hollow", centre, across, generator.inner_radius_m)];
    case "solid_ball": return [ellipse(name, centre, across, generator.radius_m)];
    case "block": return [box(name, ...[generator.min_m, generator.max_m].map((corner) => inPlane(sum(at(corner), moved))))];
    case "layered_block": {
      const [x, z] = inPlane(sum(at(generator.top_center_m), moved));
      const half = generator.size_m?.[across] / 2;
      let top = z;
      return (generator.layers ?? []).map(({ part, thickness_m }) => {
        const layer = { ...box(part, [x - half, top - thickness_m], [x + half, top]), size: thickness_m };
        top -= thickness_m;
        return layer;
      });
    }
    case "limb_segment": {
      if (across) return null;
      const { semi_axis_x_m: a, semi_axis_z_m: c, skin_thickness_m: skin, fat_thickness_m: fat, bone_offset_m: [dx, dz] = [0, 0] } = generator;
      return [
        { ...ellipse("skin", centre, 0, a, c), size: skin },
        { ...ellipse("fat", centre, 0, a - skin, c - skin), size: fat },
        { ...ellipse("muscle", centre, 0, a - skin - fat, c - skin - fat), size: c - skin - fat - generator.bone_semi_axis_z_m - dz },
        ellipse("bone", sum(centre, [dx, 0, dz]), 0, generator.bone_semi_axis_x_m, generator.bone_semi_axis_z_m),
      ];
    }
    default: return null;
  }
}

/** The shapes of a rigid body. */
function ofRigid({ shape = {}, center_m: centre }, name, across) {
  const [x, z] = [at(centre)[across], at(centre)[2]];
  const along = Math.abs(at(shape.axis)[across]) > 0.5;
  const half = (shape.half_length_m ?? 0) + (shape.kind === "capsule" ? shape.radius_m : 0);
  if (shape.kind === "ball") return [ellipse(name, at(centre), across, shape.radius_m)];
  if (shape.kind === "box") return [{ kind: "box", name, x, z, a: shape.half_extents_m?.[across], c: shape.half_extents_m?.[2] }];
  if (shape.kind === "capsule" || shape.kind === "cylinder") return [{ kind: "box", name, x, z, a: along ? half : shape.radius_m, c: Math.abs(at(shape.axis)[2]) > 0.5 ? half : shape.radius_m, round: shape.kind === "capsule" && shape.radius_m }];
  return null;
}

/** The parts of an uploaded mesh in its sections. */
function ofSections(body, sections, across) {
  return outlinesOf(body, sections, across).map(({ name, isHole, lines }) => {
    const points = lines.flat();
    const end = (of, k) => points.reduce((extreme, point) => of(extreme, point[k]), points[0][k]);
    const fill = isHole ? COLOURS.bone : colourOfPart(body, name);
    return { ...box(name, [0, 1].map((k) => end(Math.min, k)), [0, 1].map((k) => end(Math.max, k))), kind: "outline", lines, fill };
  });
}

/** The shapes of a body; null if they cannot be drawn. */
function shapesOf(body, sections, across) {
  const { translation_m: moved, ...turned } = body?.placement ?? {};
  const generator = Object.keys(turned).length ? null : body?.mesh?.generator;
  const found = sections ? ofSections(body, sections, across) : body?.rigid ? ofRigid(body.rigid, body.name, across) : generator ? ofGenerator(generator, at(moved), body.name, across) : null;
  return found?.every(({ x, z, a, c }) => [x, z, a, c].every(number) && a > 0 && c > 0) ? found : null;
}

/** Why the section of an uploaded body has nothing to draw; empty if it has. */
function lack({ name }, sections, plane) {
  if (!sections.every(Boolean)) return `The section of ${name} is loading …`;
  const { refused } = sections.find((section) => section.refused) ?? {};
  if (refused) return `${name} is not drawn: ${refused}`;
  return sections.some(({ parts }) => parts.length) ? "" : `The plane through the projectile, ${plane}, does not meet ${name}.`;
}

/** Where a body begins: the centre of what has one. */
const startOf = (body) => sum(at(body?.rigid?.center_m ?? body?.mesh?.generator?.center_m), at(body?.placement?.translation_m));

/** What of a scene can be drawn: shapes with their colours, arrows of velocity, boxes that scans are cropped to, and what to say of the rest. */
function drawing(scene, sections) {
  const bodies = Array.isArray(scene?.bodies) ? scene.bodies : [];
  const projectile = bodies.find((body) => body?.role === "projectile");
  const uploaded = bodies.filter((body) => uploadedIn(body).length);
  const [vx, vy, vz] = at(projectile?.velocity_m_per_s);
  // The plane has the path in it.
  const across = uploaded.length && Math.abs(vy) > Math.max(Math.abs(vx), Math.abs(vz)) ? 1 : 0;
  const place = startOf(projectile)[1 - across];
  const cuts = sections.at(uploaded.map(uploadedIn), 1 - across, place);
  const plane = uploaded.length ? `${"yx"[across]} = ${setting(1e3 * place)} mm` : "";
  const [shapes, arrows, crops, hidden, notes] = [[], [], [], [], []];
  for (const body of bodies) {
    const cut = cuts[uploaded.indexOf(body)];
    const missing = cut && lack(body, cut, plane);
    const found = missing ? [] : shapesOf(body, cut, across);
    if (missing) notes.push(missing);
    if (!found) hidden.push(body?.name ?? "a body");
    if (!found?.length) continue;
    const crop = cut && cropOf(body, across);
    const clip = crop ? `crop-${crops.push(crop)}` : null;
    const fillOf = ({ name, fill }) => fill ?? (name === "hollow" ? "#fff" : body.role === "projectile" ? COLOURS.projectile : colourOfPart(body, name));
    shapes.push(...found.map((shape) => ({ ...shape, fill: fillOf(shape), clip })));
    const velocity = at(body.velocity_m_per_s);
    if (Math.hypot(...velocity) > 0) arrows.push({ from: found[0], speed: Math.hypot(...velocity), along: [velocity[across], velocity[2]] });
  }
  if (hidden.length) notes.push(`Not drawn, because the shape is known only from the mesh: ${hidden.join(", ")}.`);
  return { shapes, arrows, crops, notes, plane };
}

/** Name and size: the thickness of a layer, else the width. */
function labelOf({ name, size, a }) {
  const short = name.length > LONGEST_NAME ? `${name.slice(0, LONGEST_NAME - 1).trimEnd()}…` : name;
  return `${short} ${setting(Number((1e3 * (size ?? 2 * a)).toPrecision(3)))} mm`;
}

export class GeometryPreview {
  element = html("div", { class: "geometry" });
  #scene = null;
  #sections = new Sections(() => this.show(this.#scene));

  leave() {
    this.#sections.leave();
  }

  /** Draws a scene document, as far as it is one. */
  show(scene) {
    this.#scene = scene;
    const { shapes, arrows, crops, notes, plane } = drawing(scene, this.#sections);
    const note = notes.map((words) => html("p", { class: "quiet" }, words));
    if (!shapes.length) return this.element.replaceChildren(...(note.length ? note : [html("p", { class: "quiet" }, "Nothing to draw yet.")]));
    const [left, right] = [Math.min(...shapes.map((s) => s.x - s.a)), Math.max(...shapes.map((s) => s.x + s.a))];
    const [low, high] = [Math.min(...shapes.map((s) => s.z - s.c)), Math.max(...shapes.map((s) => s.z + s.c))];
    const room = 1.15;
    const scale = Math.min((WIDTH - NAMES - 2 * EDGE) / (right - left), (HEIGHT - 2 * EDGE) / (high - low)) / room;
    const place = (x, z) => [(WIDTH - NAMES) / 2 + (x - (left + right) / 2) * scale, HEIGHT / 2 - (z - (low + high) / 2) * scale];
    const words = shapes.filter(({ name }) => name !== "hollow").map(labelOf).join(", ");
    this.element.replaceChildren(
      svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `Section of the scene: ${words}` },
        shapes.map((shape) => drawn(shape, place, scale)), crops.map((crop, i) => cropBox(crop, `crop-${i + 1}`, [[left, low], [right, high]], place)), this.#names(shapes, place, scale), arrows.map((arrow) => this.#arrow(arrow, place, scale)), scaleBar(scale),
        plane && svg("text", { x: WIDTH - 10, y: HEIGHT - 10, "text-anchor": "end" }, `section at ${plane}`)),
      ...note,
    );
  }

  /** The name and the width of each shape at the right, with a line to it. */
  #names(shapes, place, scale) {
    let lowest = 4;
    const largest = shapes.filter(({ name }) => name !== "hollow").sort((one, other) => other.a * other.c - one.a * one.c).slice(0, MOST_NAMES);
    const named = largest.map((shape) => ({ ...shape, top: place(shape.x, shape.z + shape.c)[1] })).sort((a, b) => a.top - b.top);
    return named.map((shape) => {
      const { c } = shape;
      const [px, py] = place(...pointOf(shape));
      const y = Math.max(py + 0.2 * Math.min(8, c * scale), lowest + 14);
      lowest = y;
      return [
        svg("path", { d: `M${px.toFixed(1)} ${py.toFixed(1)}L${WIDTH - NAMES} ${y.toFixed(1)}h6`, class: "leader" }),
        svg("text", { x: WIDTH - NAMES + 10, y: (y + 4).toFixed(1) }, labelOf(shape)),
      ];
    });
  }

  #arrow({ from, speed, along }, place, scale) {
    const [dx, dz] = along.map((component) => component / speed);
    const length = Math.min(60, 26 + 0.4 * from.c * scale);
    const [x, y] = place(from.x, from.z);
    const [tx, ty] = [x + dx * length, y - dz * length];
    const [hx, hy] = [tx - 9 * dx, ty + 9 * dz];
    return [
      svg("path", { d: `M${x.toFixed(1)} ${y.toFixed(1)}L${tx.toFixed(1)} ${ty.toFixed(1)}M${(hx - 5 * dz).toFixed(1)} ${(hy - 5 * dx).toFixed(1)}L${tx.toFixed(1)} ${ty.toFixed(1)}L${(hx + 5 * dz).toFixed(1)} ${(hy + 5 * dx).toFixed(1)}`, class: "arrow" }),
      svg("text", { x: 10, y: 20 }, `${setting(speed)} m/s`),
    ];
  }
}

/** The point of a shape that its name leads to: above at the right. */
function pointOf({ lines, x, z, a, c }) {
  const [towards_x, towards_z] = [0.5, 0.86];
  if (!lines) return [x + towards_x * a, z + towards_z * c];
  const along = ([u, v]) => (towards_x * (u - x)) / a + (towards_z * (v - z)) / c;
  return lines.flat().reduce((best, point) => (along(point) > along(best) ? point : best));
}

/** Closed lines; what is beyond a crop is pale. */
function drawnOutline({ lines, clip, fill }, place) {
  const words = lines.map((line) => `M${line.map(([u, v]) => place(u, v).map((p) => p.toFixed(1)).join(" ")).join("L")}Z`);
  const path = (more) => svg("path", { d: words.join(""), fill, stroke: "#22262c", "stroke-width": 0.6, ...more });
  return clip ? [path({ opacity: 0.25 }), path({ "clip-path": `url(#${clip})` })] : path({});
}

/** The box that a scan is cropped to, as far as there is something. */
function cropBox([low, high], id, [least, most], place) {
  const corners = [low.map((c, k) => Math.max(c, least[k])), high.map((c, k) => Math.min(c, most[k]))];
  const [[x0, y1], [x1, y0]] = corners.map(([u, v]) => place(u, v));
  const frame = { x: x0.toFixed(1), y: y0.toFixed(1), width: Math.max(0, x1 - x0).toFixed(1), height: Math.max(0, y1 - y0).toFixed(1) };
  return [svg("clipPath", { id }, svg("rect", frame)), svg("rect", { ...frame, class: "crop" })];
}

function drawn(shape, place, scale) {
  const { kind, x, z, a, c, fill, round } = shape;
  if (kind === "outline") return drawnOutline(shape, place);
  const [px, py] = place(x, z);
  const outline = { fill, stroke: "#22262c", "stroke-width": 1 };
  if (kind === "ellipse") return svg("ellipse", { cx: px.toFixed(1), cy: py.toFixed(1), rx: (a * scale).toFixed(2), ry: (c * scale).toFixed(2), ...outline });
  return svg("rect", { x: (px - a * scale).toFixed(1), y: (py - c * scale).toFixed(1), width: (2 * a * scale).toFixed(1), height: (2 * c * scale).toFixed(1), rx: ((round || 0) * scale).toFixed(1), ...outline });
}

/** A length in millimetres at the bottom. */
function scaleBar(scale) {
  const length = niceAbove(60 / scale);
  return [
    svg("path", { d: `M12 ${HEIGHT - 12}H${(12 + length * scale).toFixed(1)}`, class: "bar" }),
    svg("text", { x: 12, y: HEIGHT - 18 }, `${setting(length * 1e3)} mm`),
  ];
}
