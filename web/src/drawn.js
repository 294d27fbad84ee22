// What is drawn of a face: skin, teeth, bones, muscles and markers as meshes that follow the carriers.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Group, InstancedMesh, CylinderGeometry, Matrix4,
  Mesh, MeshBasicMaterial, MeshStandardMaterial, PlaneGeometry, Quaternion, SphereGeometry, Vector3,
} from 'three';
import { apply, applyScalars } from './fields.js';

const TUBE_MM = 0.55;
const SIDES = 6;
const MARKER_MM = 1.25;
/** How far the wall of the mouth goes below the teeth, for an open jaw, mm. */
const THROAT_MM = 12;

const geometryOf = (positions, index, colours) => {
  const geometry = new BufferGeometry();
  const dynamic = (array) => new BufferAttribute(array, 3).setUsage(DynamicDrawUsage);
  geometry.setAttribute('position', dynamic(positions));
  geometry.setAttribute('normal', dynamic(new Float32Array(positions.length)));
  if (colours) geometry.setAttribute('color', dynamic(colours));
  geometry.setIndex(new BufferAttribute(index, 1));
  return geometry;
};

const linear = (byte) => (byte <= 10 ? byte / 255 / 12.92 : ((byte / 255 + 0.055) / 1.055) ** 2.4);

/** A face that results share. */
export class Face {
  constructor(json, arrays) {
    this.json = json;
    this.muscles = json.muscles;
    this.rest = arrays.reals(json.carriers);
    this.rows = arrays.rows(json.skin);
    this.n = this.rows.start.length - 1;
    this.quads = arrays.raw(json.skin.quads);
    this.tint = Float32Array.from(arrays.raw(json.skin.colours), linear);
    this.triangles = arrays.raw(json.skin.triangles);
    this.opposite = { of: arrays.raw(json.opposite.of), rows: arrays.rows(json.opposite) };
    this.teeth = json.teeth.map((t) => ({ ...t, points: arrays.reals(t.points), triangles: arrays.raw(t.triangles) }));
    this.bones = json.bones.map((b) => ({ ...b, triangles: arrays.raw(b.triangles) }));
    const index = new Uint32Array((this.quads.length / 4) * 6);
    for (let q = 0, k = 0; q < this.quads.length; q += 4) {
      const [a, b, c, d] = [0, 1, 2, 3].map((j) => this.quads[q + j]);
      index.set([a, b, c, a, c, d], k);
      k += 6;
    }
    this.index = index;
    this.surfaceAtRest = apply(this.rows, this.rest);
    this.box = bounds(this.surfaceAtRest);
  }
}

function bounds(points) {
  const lo = [Infinity, Infinity, Infinity], hi = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < points.length; k++) {
    lo[k % 3] = Math.min(lo[k % 3], points[k]);
    hi[k % 3] = Math.max(hi[k % 3], points[k]);
  }
  return { lo, hi };
}

/** The meshes of one result. */
export class Drawn {
  constructor(result) {
    this.result = result;
    this.face = result.face;
    this.group = new Group();
    this.makeSkin();
    this.makeTeeth();
    this.makeBones();
    this.makeMuscles();
    this.makeMarkers();
  }

  makeSkin() {
    const { face } = this;
    this.positions = new Float32Array(face.surfaceAtRest);
    const geometry = geometryOf(this.positions, face.index, new Float32Array(face.tint));
    this.material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.62, side: DoubleSide });
    this.skin = this.add(new Mesh(geometry, this.material));
    this.skin.renderOrder = 1;
    this.moved = new Float32Array(this.positions.length);
  }

  add(mesh) {
    mesh.frustumCulled = false;
    this.group.add(mesh);
    return mesh;
  }

  makeTeeth() {
    this.teeth = new Group();
    this.group.add(this.teeth);
    const material = new MeshStandardMaterial({ color: new Color(0xf3ecd9), roughness: 0.35 });
    for (const tooth of this.face.teeth) {
      const geometry = geometryOf(tooth.points, tooth.triangles);
      geometry.computeVertexNormals();
      const mesh = new Mesh(geometry, material);
      mesh.matrixAutoUpdate = false;
      mesh.frustumCulled = false;
      this.teeth.add(mesh);
    }
    this.makeThroat();
  }

  /** A dark wall behind the arches, seen from the front only: the mouth has an inside. */
  makeThroat() {
    const { teeth } = this.face;
    if (!teeth.length) return;
    const boxes = teeth.map((t) => bounds(t.points));
    const lo = [0, 1, 2].map((c) => Math.min(...boxes.map((b) => b.lo[c])));
    const hi = [0, 1, 2].map((c) => Math.max(...boxes.map((b) => b.hi[c])));
    const wall = new PlaneGeometry(hi[0] - lo[0], hi[1] - lo[1] + THROAT_MM);
    wall.translate((lo[0] + hi[0]) / 2, (lo[1] + hi[1] - THROAT_MM) / 2, lo[2] + 0.35 * (hi[2] - lo[2]));
    const mesh = new Mesh(wall, new MeshBasicMaterial({ color: new Color(0x2d1110) }));
    mesh.frustumCulled = false;
    this.teeth.add(mesh);
    this.throat = mesh;
  }

  makeBones() {
    this.bones = new Group();
    this.bones.visible = false;
    this.group.add(this.bones);
    const material = new MeshStandardMaterial({ color: new Color(0xc9bfa6), roughness: 0.85, side: DoubleSide, flatShading: true });
    this.bonePoints = new Float32Array(this.face.rest);
    const position = new BufferAttribute(this.bonePoints, 3).setUsage(DynamicDrawUsage);
    for (const bone of this.face.bones) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', position);
      geometry.setIndex(new BufferAttribute(bone.triangles, 1));
      const mesh = new Mesh(geometry, material);
      mesh.frustumCulled = false;
      this.bones.add(mesh);
    }
  }

  makeMuscles() {
    const { muscles } = this.face;
    const rings = muscles.flatMap((m) => m.fibres).reduce((n, [, points]) => n + points, 0);
    this.tubes = { positions: new Float32Array(3 * SIDES * rings), colours: new Float32Array(3 * SIDES * rings), runs: [] };
    const index = [];
    let first = 0;
    muscles.forEach((muscle, m) => {
      for (const [carrier, points, closed] of muscle.fibres) {
        this.tubes.runs.push({ muscle: m, carrier, points, closed, first });
        for (let k = 0; k < (closed ? points : points - 1); k++) {
          const [a, b] = [first + k, first + ((k + 1) % points)];
          for (let s = 0; s < SIDES; s++) {
            const t = (s + 1) % SIDES;
            const [p, q, r, v] = [a * SIDES + s, a * SIDES + t, b * SIDES + t, b * SIDES + s];
            index.push(p, q, r, p, r, v);
          }
        }
        first += points;
      }
    });
    const geometry = geometryOf(this.tubes.positions, Uint32Array.from(index), this.tubes.colours);
    this.tubes.normals = geometry.attributes.normal.array;
    this.muscles = this.add(new Mesh(geometry, new MeshStandardMaterial({ vertexColors: true, roughness: 0.7, side: DoubleSide })));
    this.muscles.visible = false;
  }

  makeMarkers() {
    const { markers } = this.result.json;
    this.markers = new Group();
    this.markers.visible = false;
    this.group.add(this.markers);
    const ball = new SphereGeometry(MARKER_MM, 16, 10);
    const stick = new CylinderGeometry(0.35, 0.35, 1, 8);
    this.marks = {};
    // What tissue covers is drawn a second time, faintly, over it.
    const sets = { residual: stick, measured: ball, model: ball };
    for (const [name, geometry] of Object.entries(sets)) {
      const materials = [new MeshBasicMaterial(), new MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.3 })];
      this.marks[name] = materials.map((material, k) => {
        const mesh = new InstancedMesh(geometry, material, Math.max(markers.length, 1));
        mesh.count = markers.length;
        mesh.frustumCulled = false;
        mesh.renderOrder = 2 + k;
        this.markers.add(mesh);
        return mesh;
      });
    }
  }

  colourMarkers({ measured, model, residual }) {
    const set = (name, colour) => this.marks[name].forEach((mesh) => mesh.material.color.set(colour));
    set('measured', measured);
    set('model', model);
    set('residual', residual);
  }

  /** Takes everything to where the result is. */
  update() {
    const { face, result } = this;
    const x = this.bonePoints;
    for (let k = 0; k < x.length; k++) x[k] = face.rest[k] + result.u[k];
    apply(face.rows, result.u, this.moved);
    for (let k = 0; k < this.positions.length; k++) this.positions[k] = face.surfaceAtRest[k] + this.moved[k];
    this.shadeSkin();
    const { position, normal } = this.skin.geometry.attributes;
    position.needsUpdate = normal.needsUpdate = true;
    if (this.bones.visible) this.bones.children.forEach((m) => (m.geometry.attributes.position.needsUpdate = true));
    result.teeth.forEach(([o, a, b, c], k) => {
      const mesh = this.teeth.children[k];
      const axis = (p) => new Vector3(p[0] - o[0], p[1] - o[1], p[2] - o[2]);
      mesh.matrix.makeBasis(axis(a), axis(b), axis(c)).setPosition(...o);
    });
    if (this.muscles.visible) this.bendTubes();
    if (this.markers.visible) this.placeMarkers();
  }

  shadeSkin() {
    const p = this.positions, n = this.skin.geometry.attributes.normal.array, { quads } = this.face;
    n.fill(0);
    for (let q = 0; q < quads.length; q += 4) {
      const a = 3 * quads[q], b = 3 * quads[q + 1], c = 3 * quads[q + 2], d = 3 * quads[q + 3];
      const ux = p[c] - p[a], uy = p[c + 1] - p[a + 1], uz = p[c + 2] - p[a + 2];
      const vx = p[d] - p[b], vy = p[d + 1] - p[b + 1], vz = p[d + 2] - p[b + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      for (const k of [a, b, c, d]) {
        n[k] += x;
        n[k + 1] += y;
        n[k + 2] += z;
      }
    }
    for (let k = 0; k < n.length; k += 3) {
      const length = Math.hypot(n[k], n[k + 1], n[k + 2]) || 1;
      n[k] /= length;
      n[k + 1] /= length;
      n[k + 2] /= length;
    }
  }

  bendTubes() {
    const { positions, normals, colours, runs } = this.tubes;
    const x = this.bonePoints;
    const [t, side, other] = [new Vector3(), new Vector3(), new Vector3()];
    for (const { muscle, carrier, points, closed, first } of runs) {
      const colour = muscleColour(this.result.activation[muscle]);
      side.set(0, 0, 1);
      for (let k = 0; k < points; k++) {
        const at = (j) => 3 * (carrier + (closed ? (j + points) % points : Math.min(Math.max(j, 0), points - 1)));
        const [a, b, here] = [at(k - 1), at(k + 1), at(k)];
        t.set(x[b] - x[a], x[b + 1] - x[a + 1], x[b + 2] - x[a + 2]).normalize();
        side.addScaledVector(t, -side.dot(t));
        if (side.lengthSq() < 1e-4) side.set(Math.abs(t.x) < 0.6 ? 1 : 0, Math.abs(t.x) < 0.6 ? 0 : 1, 0).addScaledVector(t, -side.dot(t));
        side.normalize();
        other.crossVectors(t, side);
        for (let s = 0; s < SIDES; s++) {
          const angle = (2 * Math.PI * s) / SIDES, cos = Math.cos(angle), sin = Math.sin(angle);
          const v = 3 * ((first + k) * SIDES + s);
          for (let c = 0; c < 3; c++) {
            const out = cos * side.getComponent(c) + sin * other.getComponent(c);
            normals[v + c] = out;
            positions[v + c] = x[here + c] + TUBE_MM * out;
            colours[v + c] = colour[c];
          }
        }
      }
    }
    const { position, normal, color } = this.muscles.geometry.attributes;
    position.needsUpdate = normal.needsUpdate = color.needsUpdate = true;
  }

  placeMarkers() {
    const scaled = new Matrix4(), [up, along] = [new Vector3(0, 1, 0), new Vector3()];
    this.result.json.markers.forEach((marker, k) => {
      const u = [0, 0, 0];
      if (marker.place) {
        marker.place.carriers.forEach((node, j) => u.forEach((_, c) => (u[c] += marker.place.weights[j] * this.result.u[3 * node + c])));
      } else u.splice(0, 3, ...marker.model);
      const model = marker.rest.map((p, c) => p + u[c]);
      // A component that was not measured is the model's: the stick shows the residual alone.
      const { off } = this.result;
      const measured = off ? model.map((p, c) => p + off.mm[3 * k + c]) : marker.rest.map((p, c) => p + (marker.measured[c] ?? u[c]));
      const put = (name, matrix) => this.marks[name].forEach((mesh) => mesh.setMatrixAt(k, matrix));
      put('model', scaled.makeTranslation(...model));
      if (off && !off.seen[k]) {
        // Not seen in this frame.
        put('measured', scaled.makeScale(0, 0, 0));
        put('residual', scaled);
        return;
      }
      put('measured', scaled.makeTranslation(...measured));
      along.set(...measured.map((p, c) => p - model[c]));
      const length = along.length();
      const turn = new Quaternion().setFromUnitVectors(up, length > 1e-6 ? along.clone().divideScalar(length) : up);
      const middle = new Vector3(...model).addScaledVector(along, 0.5);
      put('residual', scaled.compose(middle, turn, new Vector3(1, Math.max(length, 1e-3), 1)));
    });
    for (const meshes of Object.values(this.marks)) meshes.forEach((mesh) => (mesh.instanceMatrix.needsUpdate = true));
  }

  /** Colours the skin by `values` (one a carrier, NaN where there is none) up to `largest`, or as it is. */
  colour(values, largest, map) {
    const colours = this.skin.geometry.attributes.color.array;
    const { tint, n, rows } = this.face;
    let most = 0;
    if (!values) colours.set(tint);
    else {
      const at = applyScalars(rows, values);
      for (let v = 0; v < n; v++) {
        if (Number.isNaN(at[v])) {
          for (let c = 0; c < 3; c++) colours[3 * v + c] = 0.55 * tint[3 * v + c] + 0.2;
          continue;
        }
        most = Math.max(most, at[v]);
        const t = Math.min(Math.max(at[v] / largest, 0), 1) * (map.length - 1);
        const k = Math.min(Math.floor(t), map.length - 2), f = t - k;
        for (let c = 0; c < 3; c++) colours[3 * v + c] = map[k][c] + f * (map[k + 1][c] - map[k][c]);
      }
    }
    this.material.roughness = values ? 1 : 0.62;
    this.skin.geometry.attributes.color.needsUpdate = true;
    return most;
  }
}

export const linearColours = (map) => map.map((colour) => colour.map(linear));

const RESTING = [0.44, 0.41, 0.39], SLIGHT = [214, 150, 130].map(linear), FULL = [150, 10, 20].map(linear);

export function muscleColour(a) {
  if (!(a > 0.005)) return RESTING;
  const t = Math.sqrt(Math.min(a, 1));
  return SLIGHT.map((x, c) => x + t * (FULL[c] - x));
}
