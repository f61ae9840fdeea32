// Lines and points over the bodies: contacts with their forces, joints, bounds, axes, centers of mass.
import { paletteColor } from "scree/colors";
import { kLight, kPoseLength, writeRotation } from "scree/layer";
import { kWords } from "scree/live";
import * as THREE from "three";

const kJointColor = [255, 80, 200];
const kBoundColor = [40, 60, 80];
const kCenterColor = [20, 20, 20];
const kAxes = [[220, 50, 50], [40, 150, 60], [50, 80, 220]];

// Line segments whose number changes.
class Lines {
  constructor(parent) {
    const material = new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false, transparent: true });
    this.segments = new THREE.LineSegments(new THREE.BufferGeometry(), material);
    this.segments.frustumCulled = false;
    this.segments.renderOrder = 1;
    parent.add(this.segments);
    this.count = 0;
    this.makeRoom(1024);
  }

  // Keeps the lines that are there.
  makeRoom(capacity) {
    const { geometry } = this.segments;
    const larger = new THREE.BufferGeometry();
    for (const name of ["position", "color"]) {
      const list = new THREE.BufferAttribute(new Float32Array(6 * capacity), 3);
      if (this.count > 0) list.array.set(geometry.attributes[name].array);
      larger.setAttribute(name, list.setUsage(THREE.DynamicDrawUsage));
    }
    geometry.dispose();
    this.segments.geometry = larger;
    this.capacity = capacity;
    this.positions = larger.attributes.position.array;
    this.colors = larger.attributes.color.array;
  }

  begin() {
    this.count = 0;
  }

  add(ax, ay, az, bx, by, bz, color) {
    if (this.count === this.capacity) this.makeRoom(2 * this.capacity);
    const { positions, colors } = this;
    const at = 6 * this.count++;
    positions[at] = ax;
    positions[at + 1] = ay;
    positions[at + 2] = az;
    positions[at + 3] = bx;
    positions[at + 4] = by;
    positions[at + 5] = bz;
    for (let part = 0; part < 3; ++part) colors[at + part] = colors[at + 3 + part] = kLight[color[part] | 0];
  }

  // Three lines along the axes.
  addCross(x, y, z, size, color) {
    this.add(x - size, y, z, x + size, y, z, color);
    this.add(x, y - size, z, x, y + size, z, color);
    this.add(x, y, z - size, x, y, z + size, color);
  }

  end() {
    const { geometry } = this.segments;
    geometry.setDrawRange(0, 2 * this.count);
    for (const list of Object.values(geometry.attributes)) {
      list.clearUpdateRanges();
      list.addUpdateRange(0, 6 * this.count);
      list.needsUpdate = this.count > 0;
    }
    this.segments.visible = this.count > 0;
  }
}

export class Marks {
  constructor(scene, model) {
    this.scene = scene;
    this.model = model;
    this.lines = new Lines(scene.root);
    this.shown = new Set();  // of contacts, joints, bounds, axes, centers
    this.held = undefined;   // two points: what is dragged, and whereto
    this.count = 0;
  }

  draw(state) {
    const { lines } = this;
    if (this.shown.size === 0 && !this.held && this.count === 0) return;
    lines.begin();
    if (this.shown.has("contacts") && state.frame) this.addContacts(state.frame);
    if (this.shown.has("joints") && state.frame) this.addJoints(state.frame);
    if (this.shown.has("bounds")) this.addBounds();
    if (this.shown.has("axes") || this.shown.has("centers")) this.addFrames(state);
    if (this.held) lines.add(...this.held[0], ...this.held[1], kJointColor);
    this.count = lines.count;
    lines.end();
  }

  // A cross at each contact, and its force along the normal; the longest is as long as two bodies.
  addContacts({ contacts }) {
    const cross = 0.06 * this.model.size;
    let largest = 0;
    for (let i = 0; i < contacts.length; i += kWords) largest = Math.max(largest, contacts[i + 8]);
    for (let i = 0; i < contacts.length; i += kWords) {
      const x = contacts[i + 2], y = contacts[i + 3], z = contacts[i + 4];
      const color = paletteColor(contacts[i + 9] + 1);
      this.lines.addCross(x, y, z, cross, color);
      const length = largest > 0 ? (2 * this.model.size * contacts[i + 8]) / largest : 0;
      if (length === 0) continue;
      this.lines.add(x, y, z, x + length * contacts[i + 5], y + length * contacts[i + 6], z + length * contacts[i + 7], color);
    }
  }

  addJoints({ joints }) {
    const cross = 0.08 * this.model.size;
    for (let i = 0; i < joints.length; i += kWords) {
      this.lines.add(...joints.subarray(i, i + 6), kJointColor);
      this.lines.addCross(joints[i], joints[i + 1], joints[i + 2], cross, kJointColor);
    }
  }

  // Boxes along the world's axes around what moves: around the boxes of its pieces, so they are no less than its own.
  addBounds() {
    const bounds = new Map();  // by body: low x, y, z, high x, y, z
    for (const mesh of this.scene.moving.meshes) {
      const { geometry } = mesh;
      if (!geometry.boundingBox) geometry.computeBoundingBox();
      const { min, max } = geometry.boundingBox;
      const middle = [(min.x + max.x) / 2, (min.y + max.y) / 2, (min.z + max.z) / 2];
      const half = [(max.x - min.x) / 2, (max.y - min.y) / 2, (max.z - min.z) / 2];
      const { matrices, bodies } = mesh.userData;
      for (let place = 0; place < mesh.count; ++place) {
        const m = 16 * place;
        if (matrices[m] === 0 && matrices[m + 1] === 0 && matrices[m + 2] === 0) continue;  // it is hidden, see walls.js
        let box = bounds.get(bodies[place]);
        if (!box) bounds.set(bodies[place], (box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity]));
        for (let row = 0; row < 3; ++row) {
          const a = matrices[m + row], b = matrices[m + 4 + row], c = matrices[m + 8 + row];
          const center = a * middle[0] + b * middle[1] + c * middle[2] + matrices[m + 12 + row];
          const reach = Math.abs(a) * half[0] + Math.abs(b) * half[1] + Math.abs(c) * half[2];
          box[row] = Math.min(box[row], center - reach);
          box[3 + row] = Math.max(box[3 + row], center + reach);
        }
      }
    }
    for (const box of bounds.values()) this.addBox(box);
  }

  addBox([ax, ay, az, bx, by, bz]) {
    const { lines } = this;
    for (const y of [ay, by]) {
      for (const z of [az, bz]) lines.add(ax, y, z, bx, y, z, kBoundColor);
      for (const x of [ax, bx]) lines.add(x, y, az, x, y, bz, kBoundColor);
    }
    for (const x of [ax, bx]) for (const z of [az, bz]) lines.add(x, ay, z, x, by, z, kBoundColor);
  }

  // From the body's origin along its axes, and a cross at its center of mass.
  addFrames({ numbers, poses }) {
    const r = new Float32Array(9);
    const length = 0.8 * this.model.size;
    for (let i = 0, at = 0; i < numbers.length; ++i, at += kPoseLength) {
      const x = poses[at], y = poses[at + 1], z = poses[at + 2];
      writeRotation(poses[at + 3], poses[at + 4], poses[at + 5], poses[at + 6], 1, 1, 1, r);
      if (this.shown.has("axes")) {
        for (let k = 0; k < 9; k += 3)
          this.lines.add(x, y, z, x + length * r[k], y + length * r[k + 1], z + length * r[k + 2], kAxes[k / 3]);
      }
      const { center } = this.model.bodies[numbers[i]];
      if (!this.shown.has("centers") || !center) continue;
      const [cx, cy, cz] = center;
      this.lines.addCross(x + r[0] * cx + r[3] * cy + r[6] * cz, y + r[1] * cx + r[4] * cy + r[7] * cz,
        z + r[2] * cx + r[5] * cy + r[8] * cz, 0.12 * this.model.size, kCenterColor);
    }
  }
}
