// Fields on the skin: one value a carrier.

/** Each row's weighted sum of the vectors `x` (xyz). */
export function apply({ start, column, share }, x, out = new Float32Array(3 * (start.length - 1))) {
  for (let k = 0; k + 1 < start.length; k++) {
    let [a, b, c] = [0, 0, 0];
    for (let j = start[k]; j < start[k + 1]; j++) {
      const at = 3 * column[j], w = share[j];
      a += w * x[at];
      b += w * x[at + 1];
      c += w * x[at + 2];
    }
    out[3 * k] = a;
    out[3 * k + 1] = b;
    out[3 * k + 2] = c;
  }
  return out;
}

/** The same of scalars, over those that are there; NaN where less than half of a row is. */
export function applyScalars({ start, column, share }, values) {
  const out = new Float32Array(start.length - 1);
  for (let k = 0; k + 1 < start.length; k++) {
    let [sum, known] = [0, 0];
    for (let j = start[k]; j < start[k + 1]; j++) {
      const value = values[column[j]];
      if (Number.isNaN(value)) continue;
      sum += share[j] * value;
      known += share[j];
    }
    out[k] = known > 0.5 ? sum / known : NaN;
  }
  return out;
}

const none = (face) => new Float32Array(face.rest.length / 3).fill(NaN);

/** Length of the displacement of each carrier, mm. */
export function displacement({ face, u }) {
  return none(face).map((_, k) => Math.hypot(u[3 * k], u[3 * k + 1], u[3 * k + 2]));
}

/** Largest magnitude of the principal logarithmic strains in the plane of the skin, per cent; mean of the facets about a node. */
export function stretch({ face, u }) {
  const { rest, triangles } = face;
  const sum = new Float32Array(rest.length / 3), area = new Float32Array(rest.length / 3);
  const edge = (at, p, q) => [at(p, 0, q), at(p, 1, q), at(p, 2, q)];
  const before = (p, c, q) => rest[3 * q + c] - rest[3 * p + c];
  const after = (p, c, q) => before(p, c, q) + u[3 * q + c] - u[3 * p + c];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  for (let t = 0; t < triangles.length; t += 3) {
    const [p, q, r] = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const metric = (at) => {
      const [a, b] = [edge(at, p, q), edge(at, p, r)];
      return [dot(a, a), dot(a, b), dot(b, b)];
    };
    const [A, B, C] = metric(before), [a, b, c] = metric(after);
    const det = A * C - B * B;
    if (!(det > 0)) continue;
    // The squared stretches are the eigenvalues of G^-1 g, the metrics of the triangle at rest and moved.
    const trace = (C * a - 2 * B * b + A * c) / det, product = (a * c - b * b) / det;
    const root = Math.sqrt(Math.max(trace * trace / 4 - product, 0));
    const strains = [trace / 2 + root, trace / 2 - root].map((l) => Math.abs(0.5 * Math.log(Math.max(l, 1e-6))));
    const weight = Math.sqrt(det);
    for (const k of [p, q, r]) {
      sum[k] += weight * 100 * Math.max(...strains);
      area[k] += weight;
    }
  }
  return sum.map((s, k) => (area[k] > 0 ? s / area[k] : NaN));
}

/** How far each point's movement is from the mirror image of that of the skin opposite, mm. */
export function asymmetry({ face, u }) {
  const { of, rows } = face.opposite;
  const out = none(face), other = apply(rows, u);
  of.forEach((node, k) => {
    const [x, y, z] = [u[3 * node] + other[3 * k], u[3 * node + 1] - other[3 * k + 1], u[3 * node + 2] - other[3 * k + 2]];
    out[node] = Math.hypot(x, y, z);
  });
  return out;
}

/** Contact pressure, kPa; null where it is not known. */
export function pressure({ face, pressure: of }) {
  if (!of) return null;
  const out = none(face);
  out.set(of);
  return out;
}

/** The `share` quantile of the values that are numbers. */
export function quantile(values, share) {
  const sorted = Float32Array.from(values.filter((v) => !Number.isNaN(v))).sort();
  return sorted.length ? sorted[Math.min(Math.floor(share * sorted.length), sorted.length - 1)] : 0;
}

/** `x` rounded up to a short number. */
export function roundUp(x) {
  if (!(x > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  return [1, 1.2, 1.6, 2, 2.4, 3.2, 4, 6, 8, 10].map((k) => k * power).find((v) => v >= x * (1 - 1e-6)) ?? 10 * power;
}
