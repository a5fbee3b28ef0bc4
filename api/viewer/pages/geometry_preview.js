// The geometry of a scene before anything runs: a section through the projectile and the target, to scale, drawn from the document alone.

import { html, svg } from "../dom.js";
import { niceAbove, setting } from "../format.js";

const [WIDTH, HEIGHT, EDGE] = [460, 300, 14];
const COLOURS = { skin: "#e6b8a2", fat: "#f3dd9a", muscle: "#c06a5c", bone: "#ece5d3", projectile: "#8b919c", other: "#cfd6dd" };

const sum = (a, b) => a.map((c, k) => c + (b[k] ?? 0));
const number = (value) => typeof value === "number" && Number.isFinite(value);
const at = (vector) => (Array.isArray(vector) && vector.length === 3 && vector.every(number) ? vector : [0, 0, 0]);

/** An ellipse in the plane of x and z [m]. */
const ellipse = (name, centre, a, c = a) => ({ kind: "ellipse", name, x: centre[0], z: centre[2], a, c });
const box = (name, [x0, , z0], [x1, , z1]) => ({ kind: "box", name, x: (x0 + x1) / 2, z: (z0 + z1) / 2, a: (x1 - x0) / 2, c: (z1 - z0) / 2 });

/** The shapes of a generated mesh, the outer ones first. */
function ofGenerator(generator, moved, name) {
  const centre = sum(at(generator.center_m), moved);
  switch (generator.kind) {
    case "hollow_ball": return [ellipse(name, centre, generator.outer_radius_m), { ...ellipse("hollow", centre, generator.inner_radius_m) }];
    case "solid_ball": return [ellipse(name, centre, generator.radius_m)];
    case "block": return [box(name, sum(at(generator.min_m), moved), sum(at(generator.max_m), moved))];
    case "layered_block": {
      const [x, y, z] = sum(at(generator.top_center_m), moved);
      const half = generator.size_m?.[0] / 2;
      let top = z;
      return (generator.layers ?? []).map(({ part, thickness_m }) => {
        const layer = { ...box(part, [x - half, y, top - thickness_m], [x + half, y, top]), size: thickness_m };
        top -= thickness_m;
        return layer;
      });
    }
    case "limb_segment": {
      const { semi_axis_x_m: a, semi_axis_z_m: c, skin_thickness_m: skin, fat_thickness_m: fat, bone_offset_m: [dx, dz] = [0, 0] } = generator;
      return [
        { ...ellipse("skin", centre, a, c), size: skin },
        { ...ellipse("fat", centre, a - skin, c - skin), size: fat },
        { ...ellipse("muscle", centre, a - skin - fat, c - skin - fat), size: c - skin - fat - generator.bone_semi_axis_z_m - dz },
        ellipse("bone", sum(centre, [dx, 0, dz]), generator.bone_semi_axis_x_m, generator.bone_semi_axis_z_m),
      ];
    }
    default: return null;
  }
}

/** The shapes of a rigid body. */
function ofRigid({ shape = {}, center_m: centre }, name) {
  const [x, , z] = at(centre);
  const along = Math.abs(at(shape.axis)[0]) > 0.5;
  const half = (shape.half_length_m ?? 0) + (shape.kind === "capsule" ? shape.radius_m : 0);
  if (shape.kind === "ball") return [ellipse(name, at(centre), shape.radius_m)];
  if (shape.kind === "box") return [{ kind: "box", name, x, z, a: shape.half_extents_m?.[0], c: shape.half_extents_m?.[2] }];
  if (shape.kind === "capsule" || shape.kind === "cylinder") return [{ kind: "box", name, x, z, a: along ? half : shape.radius_m, c: Math.abs(at(shape.axis)[2]) > 0.5 ? half : shape.radius_m, round: shape.kind === "capsule" && shape.radius_m }];
  return null;
}

/** What of a scene can be drawn: shapes with their colours, arrows of velocity, and the bodies that cannot. */
function drawing(scene) {
  const [shapes, arrows, hidden] = [[], [], []];
  for (const body of Array.isArray(scene?.bodies) ? scene.bodies : []) {
    const { translation_m: moved, ...turned } = body?.placement ?? {};
    const found = body?.rigid ? ofRigid(body.rigid, body.name) : body?.mesh?.generator && !Object.keys(turned).length ? ofGenerator(body.mesh.generator, at(moved), body.name) : null;
    const isWhole = found?.every(({ x, z, a, c }) => [x, z, a, c].every(number) && a > 0 && c > 0);
    if (!isWhole) {
      hidden.push(body?.name ?? "a body");
      continue;
    }
    const isProjectile = body.role === "projectile";
    shapes.push(...found.map((shape) => ({ ...shape, fill: shape.name === "hollow" ? "#fff" : isProjectile ? COLOURS.projectile : COLOURS[shape.name] ?? COLOURS.other })));
    const velocity = at(body.velocity_m_per_s);
    if (Math.hypot(...velocity) > 0) arrows.push({ from: found[0], velocity });
  }
  return { shapes, arrows, hidden };
}

/** Name and size: the thickness of a layer, else the width. */
function labelOf({ name, size, a }) {
  return `${name} ${setting(1e3 * (size ?? 2 * a))} mm`;
}

export class GeometryPreview {
  element = html("div", { class: "geometry" });

  /** Draws a scene document, as far as it is one. */
  show(scene) {
    const { shapes, arrows, hidden } = drawing(scene);
    const note = hidden.length ? html("p", { class: "quiet" }, `Not drawn, because only its mesh says what it looks like: ${hidden.join(", ")}.`) : "";
    if (!shapes.length) return this.element.replaceChildren(note || html("p", { class: "quiet" }, "Nothing to draw yet."));
    const [left, right] = [Math.min(...shapes.map((s) => s.x - s.a)), Math.max(...shapes.map((s) => s.x + s.a))];
    const [low, high] = [Math.min(...shapes.map((s) => s.z - s.c)), Math.max(...shapes.map((s) => s.z + s.c))];
    const room = 1.15;
    const scale = Math.min((WIDTH - 2 * EDGE) / (right - left), (HEIGHT - 2 * EDGE) / (high - low)) / room;
    const place = (x, z) => [WIDTH / 2 + (x - (left + right) / 2) * scale, HEIGHT / 2 - (z - (low + high) / 2) * scale];
    const words = shapes.filter(({ name }) => name !== "hollow").map(labelOf).join(", ");
    this.element.replaceChildren(
      svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `Section of the scene: ${words}` },
        shapes.map((shape) => drawn(shape, place, scale)), this.#names(shapes, place, scale), arrows.map((arrow) => this.#arrow(arrow, place, scale)), scaleBar(scale)),
      note,
    );
  }

  /** The name and the width of each shape at the right, with a line to it. */
  #names(shapes, place, scale) {
    let lowest = 4;
    const named = shapes.filter(({ name }) => name !== "hollow").map((shape) => ({ ...shape, top: place(shape.x, shape.z + shape.c)[1] })).sort((a, b) => a.top - b.top);
    return named.map((shape) => {
      const { x, z, a, c } = shape;
      const [px, py] = place(x + 0.5 * a, z + 0.86 * c);
      const y = Math.max(py + 0.2 * Math.min(8, c * scale), lowest + 14);
      lowest = y;
      return [
        svg("path", { d: `M${px.toFixed(1)} ${py.toFixed(1)}L${WIDTH - 118} ${y.toFixed(1)}H${WIDTH - 112}`, class: "leader" }),
        svg("text", { x: WIDTH - 108, y: (y + 4).toFixed(1) }, labelOf(shape)),
      ];
    });
  }

  #arrow({ from, velocity }, place, scale) {
    const speed = Math.hypot(...velocity);
    const [dx, dz] = [velocity[0] / speed, velocity[2] / speed];
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

function drawn({ kind, x, z, a, c, fill, round }, place, scale) {
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
