// States between two recorded frames: linear in time, rigid bodies turned the short way.

function mixed(a, b, f) {
  const now = a.slice();
  for (let i = 0; i < now.length; i++) now[i] += f * (b[i] - a[i]);
  return now;
}

/**
 * The frame at a place between frames: 2.25 is a quarter of the way from the third to the fourth. `stretch(name)` is the factor on the
 * displacements of a body; contacts are those of the nearer frame.
 */
export function frameAt(recording, place, stretch = () => 1) {
  const { frames } = recording;
  const first = Math.min(Math.floor(place), frames.length - 1);
  const [a, b, f] = [frames[first], frames[first + 1], place - first];
  const time = b && f > 0 ? a.time + f * (b.time - a.time) : a.time;
  const bodies = new Map([...a.bodies].map(([name, state]) => {
    const next = f > 0 && b?.bodies.get(name);
    const now = next ? between(state, next, f) : state;
    return [name, stretched(now, recording.bodies.get(name), time, stretch(name))];
  }));
  return { time, bodies, contacts: (f > 0.5 && b ? b : a).contacts };
}

/** The place between frames at a time [s]; the first or the last beyond the recording. */
export function placeOf({ frames }, time) {
  const after = frames.findIndex((frame) => frame.time > time);
  if (after === 0) return 0;
  if (after < 0) return frames.length - 1;
  const [a, b] = [frames[after - 1].time, frames[after].time];
  return after - 1 + (time - a) / (b - a);
}

function between(a, b, f) {
  if (a.pose) {
    const [p, q] = [a.pose, b.pose];
    const isShort = p.orientation.reduce((sum, c, i) => sum + c * q.orientation[i], 0) >= 0;
    const turned = mixed(p.orientation, q.orientation.map((c) => (isShort ? c : -c)), f);
    const norm = Math.hypot(...turned);
    return { pose: { position: mixed(p.position, q.position, f), orientation: turned.map((c) => c / norm) } };
  }
  const fields = Object.fromEntries(Object.keys(a.fields).filter((name) => b.fields[name]).map((name) => [name, mixed(a.fields[name], b.fields[name], f)]));
  return { positions: mixed(a.positions, b.positions, f), fields, eroded: a.eroded };
}

/** Displacements from the flight of the undeformed body, times a factor. */
function stretched(state, body, time, factor) {
  if (factor === 1 || !state.positions || !body?.X) return state;
  const positions = state.positions.map((x, i) => {
    const rest = body.X[i] + body.V[i % 3] * time;
    return rest + factor * (x - rest);
  });
  return { ...state, positions };
}
