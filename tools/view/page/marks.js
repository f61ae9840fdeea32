// Lines and points over the bodies: contacts with their forces, joints, bounds, axes, centers of mass.
import { paletteColor } from "scree/colors";
import { kPoseLength } from "scree/layer";
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
    this.begin();
  }

  begin() {
    this.positions = [];
    this.colors = [];
  }

  add(a, b, [red, green, blue]) {
    this.positions.push(...a, ...b);
    const color = new THREE.Color().setRGB(red / 255, green / 255, blue / 255, THREE.SRGBColorSpace);
    this.colors.push(color.r, color.g, color.b, color.r, color.g, color.b);
  }

  end() {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(this.positions, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(this.colors, 3));
    this.segments.geometry.dispose();
    this.segments.geometry = geometry;
    this.segments.visible = this.positions.length > 0;
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
    if (this.held) lines.add(...this.held, kJointColor);
    this.count = lines.positions.length / 6;
    lines.end();
  }

  // A cross at each contact, and its force along the normal; the longest is as long as two bodies.
  addContacts({ contacts }) {
    const cross = 0.06 * this.model.size;
    let largest = 0;
    for (let i = 0; i < contacts.length; i += kWords) largest = Math.max(largest, contacts[i + 8]);
    for (let i = 0; i < contacts.length; i += kWords) {
      const place = [contacts[i + 2], contacts[i + 3], contacts[i + 4]];
      const normal = [contacts[i + 5], contacts[i + 6], contacts[i + 7]];
      const color = paletteColor(contacts[i + 9] + 1);
      for (let axis = 0; axis < 3; ++axis) {
        const [a, b] = [[...place], [...place]];
        a[axis] -= cross;
        b[axis] += cross;
        this.lines.add(a, b, color);
      }
      const length = largest > 0 ? (2 * this.model.size * contacts[i + 8]) / largest : 0;
      if (length > 0) this.lines.add(place, place.map((x, axis) => x + length * normal[axis]), color);
    }
  }

  addJoints({ joints }) {
    const cross = 0.08 * this.model.size;
    for (let i = 0; i < joints.length; i += kWords) {
      const [a, b] = [[...joints.subarray(i, i + 3)], [...joints.subarray(i + 3, i + 6)]];
      this.lines.add(a, b, kJointColor);
      for (let axis = 0; axis < 3; ++axis) {
        const [low, high] = [[...a], [...a]];
        low[axis] -= cross;
        high[axis] += cross;
        this.lines.add(low, high, kJointColor);
      }
    }
  }

  // Boxes along the world's axes around what moves.
  addBounds() {
    const boxes = new Map();
    const matrix = new THREE.Matrix4();
    const box = new THREE.Box3();
    for (const mesh of this.scene.moving.meshes) {
      const { geometry } = mesh;
      if (!geometry.boundingBox) geometry.computeBoundingBox();
      for (let place = 0; place < mesh.count; ++place) {
        mesh.getMatrixAt(place, matrix);
        box.copy(geometry.boundingBox).applyMatrix4(matrix);
        const body = mesh.userData.bodies[place];
        if (boxes.has(body)) boxes.get(body).union(box);
        else boxes.set(body, box.clone());
      }
    }
    for (const { min, max } of boxes.values()) {
      const corner = (i) => [i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z];
      for (let i = 0; i < 8; ++i) {
        for (const bit of [1, 2, 4]) if (!(i & bit)) this.lines.add(corner(i), corner(i | bit), kBoundColor);
      }
    }
  }

  // From the body's origin along its axes, and a cross at its center of mass.
  addFrames({ numbers, poses }) {
    const turn = new THREE.Quaternion();
    const place = new THREE.Vector3();
    const axis = new THREE.Vector3();
    const length = 0.8 * this.model.size;
    for (let i = 0; i < numbers.length; ++i) {
      place.fromArray(poses, kPoseLength * i);
      turn.fromArray(poses, kPoseLength * i + 3);
      if (this.shown.has("axes")) {
        kAxes.forEach((color, k) => {
          axis.set(k === 0 ? length : 0, k === 1 ? length : 0, k === 2 ? length : 0).applyQuaternion(turn).add(place);
          this.lines.add(place.toArray(), axis.toArray(), color);
        });
      }
      const { center } = this.model.bodies[numbers[i]];
      if (!this.shown.has("centers") || !center) continue;
      axis.fromArray(center).applyQuaternion(turn).add(place);
      for (let k = 0; k < 3; ++k) {
        const [low, high] = [axis.toArray(), axis.toArray()];
        low[k] -= 0.12 * this.model.size;
        high[k] += 0.12 * this.model.size;
        this.lines.add(low, high, kCenterColor);
      }
    }
  }
}
