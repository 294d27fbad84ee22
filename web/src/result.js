// A result: its stored states, and the superposition of its tangent.

export class Result {
  constructor(json, face, arrays) {
    const state = (s) => ({
      ...s,
      u: s.displacement && arrays.reals(s.displacement),
      kpa: s.pressure && arrays.reals(s.pressure),
      off: s.residuals && { seen: arrays.raw(s.residuals[0]), mm: arrays.reals(s.residuals[1]) },
    });
    Object.assign(this, { json, face, title: json.title, answer: state(json.answer) });
    this.states = json.states.map(state);
    if (json.kind === 'loading') this.states.push(this.answer);
    this.tangent = json.tangent.map((ref) => arrays.reals(ref));
    this.times = this.states.map((s) => s.time);
    this.hasPressure = Boolean(this.answer.kpa);
    this.u = new Float32Array(face.rest.length);
    this.showAnswer();
  }

  get canSuperpose() {
    return this.tangent.length > 0;
  }

  /** Displacements of the carriers under `activation`, to first order about the answer. */
  superposed(activation, u = new Float32Array(this.face.rest.length)) {
    u.set(this.answer.u);
    const about = this.answer.activation;
    for (let m = 0; m < this.tangent.length; m++) {
      const step = activation[m] - about[m];
      if (step === 0) continue;
      const field = this.tangent[m];
      for (let k = 0; k < u.length; k++) u[k] += step * field[k];
    }
    return u;
  }

  /** Where the motion is shown first, 0 to 1: of a track the frame in which the muscles do most, of others the end. */
  get start() {
    if (this.json.kind !== 'track') return 1;
    const [first, last] = [this.times[0], this.times.at(-1)];
    return last > first ? (this.answer.time - first) / (last - first) : 0;
  }

  displacement(k) {
    return this.states[k].u ?? this.superposed(this.states[k].activation);
  }

  /** Goes to the moment `share`, 0 to 1 of the time from the first state to the last; straight between states. */
  showMoment(share) {
    const [first, last] = [this.times[0], this.times.at(-1)];
    const time = first + share * (last - first);
    let k = this.times.findIndex((t) => t > time);
    k = k < 0 ? this.times.length - 1 : Math.max(k - 1, 0);
    const next = Math.min(k + 1, this.times.length - 1);
    const width = this.times[next] - this.times[k];
    let t = width > 0 ? (time - this.times[k]) / width : 0;
    if (t > 1 - 1e-6) [k, t] = [next, 0];
    const mix = (a, b) => a + t * (b - a);
    const [a, b] = [this.displacement(k), t > 0 ? this.displacement(next) : null];
    for (let j = 0; j < this.u.length; j++) this.u[j] = b ? mix(a[j], b[j]) : a[j];
    const [from, to] = [this.states[k], this.states[t > 0 ? next : k]];
    this.activation = from.activation.map((x, m) => mix(x, to.activation[m]));
    const [p, q] = [from.kpa, to.kpa];
    this.pressure = p && q && p.map((x, j) => mix(x, q[j]));
    this.teeth = this.face.teeth.map((_, j) => blend(from.teeth[j], to.teeth[j], t));
    this.off = from.off && {
      seen: from.off.seen.map((seen, j) => seen & to.off.seen[j]),
      mm: from.off.mm.map((x, j) => mix(x, to.off.mm[j])),
    };
    this.moment = { share, time, state: t > 0 ? null : k, between: [k, next] };
    this.linear = false;
  }

  /** Goes to the answer as it was stored. */
  showAnswer() {
    if (this.json.kind === 'loading') return this.showMoment(1);
    this.showLinear(this.answer.activation);
    this.pressure = this.answer.kpa;
  }

  /** Goes to `activation` by superposition. */
  showLinear(activation) {
    this.activation = activation;
    this.superposed(activation, this.u);
    this.pressure = null;
    this.teeth = this.face.teeth.map((_, j) => this.answer.teeth[j] ?? STILL);
    this.linear = true;
  }
}

const STILL = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];

function blend(a = STILL, b = STILL, t) {
  return a.map((p, k) => p.map((x, c) => x + t * (b[k][c] - x)));
}
