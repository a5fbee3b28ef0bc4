// Curves over time: forces, impulses and energies of every recorded step.

const xyz = (v) => (v ? [v.x, v.y, v.z] : [0, 0, 0]);
// Recordings of older versions lack what was added since.
const sum = (items, name) => items.reduce((total, item) => total + (item[name] ?? 0), 0);

export class Series {
  /** Times of the force messages [s], and by pair their columns. */
  forceTimes = [];
  pairs = new Map();
  /** Times of the energy messages [s], and the terms of the ledger [J]. */
  energyTimes = [];
  energy = { kinetic: [], strain: [], dissipated: [], sum: [], supplied: [], absorbed: [] };

  takeForces(message) {
    this.forceTimes.push(message.time_s);
    for (const pair of message.pairs) {
      if (!this.pairs.has(pair.pair)) {
        // Of many pairs only those that have touched are recorded: before that everything is zero.
        const zeros = () => Array(this.forceTimes.length - 1).fill(0);
        const columns = { force: zeros(), impulse: zeros().map(() => [0, 0, 0]), impulseNorm: zeros(), area: zeros(), longAxis: zeros(), shortAxis: zeros() };
        this.pairs.set(pair.pair, columns);
      }
      const columns = this.pairs.get(pair.pair);
      columns.force.push(pair.force_norm_n);
      columns.impulse.push(xyz(pair.impulse_n_s));
      columns.impulseNorm.push(pair.impulse_norm_n_s);
      columns.area.push(pair.patch_area_m2);
      columns.longAxis.push(pair.patch_long_axis_m);
      columns.shortAxis.push(pair.patch_short_axis_m);
    }
  }

  takeEnergy(message) {
    const { bodies, pairs } = message;
    const kinetic = sum(bodies, "kinetic_j");
    const strain = sum(bodies, "strain_j");
    const dissipated =
      sum(bodies, "viscous_j") + sum(bodies, "eroded_j") + sum(bodies, "algorithmic_j") +
      sum(pairs, "friction_j") + sum(pairs, "numerical_contact_j") + sum(pairs, "impact_j");
    this.energyTimes.push(message.time_s);
    const terms = { kinetic, strain, dissipated, sum: kinetic + strain + dissipated };
    terms.supplied = message.initial_total_j + message.external_work_j;
    terms.absorbed = message.absorbed_by_tissue_j;
    for (const [name, value] of Object.entries(terms)) this.energy[name].push(value);
  }

  /** Mean force of a pair over a window [s] around each time [N]: |I(t + τ/2) − I(t − τ/2)| / τ. */
  meanForce(pair, window) {
    const { impulse } = this.pairs.get(pair);
    const times = this.forceTimes;
    return times.map((time) => {
      const [from, to] = [time - window / 2, time + window / 2];
      if (from < times[0] || to > times.at(-1)) return null;
      const [a, b] = [this.#impulseAt(impulse, from), this.#impulseAt(impulse, to)];
      return Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) / window;
    });
  }

  /** Impulse at a time, linear between the recorded steps. */
  #impulseAt(impulse, time) {
    const times = this.forceTimes;
    let [low, high] = [0, times.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    const span = times[high] - times[low];
    const fraction = span > 0 ? Math.min(Math.max((time - times[low]) / span, 0), 1) : 0;
    return impulse[low].map((value, k) => value + fraction * (impulse[high][k] - value));
  }
}
