// Draws bodies that stand still. Many of them are drawn by cells of a grid: those out of sight cost nothing, and of
// more than can be drawn the far cells are drawn as the boxes around them.
import { kFixed } from "scree/colors";
import { kFine } from "scree/detail";
import { kLight, Layer } from "scree/layer";
import * as THREE from "three";

const kFew = 20000;        // bodies: drawn as one
const kBodiesInCell = 2000;

export class Field {
  constructor(parent, model, material) {
    Object.assign(this, { parent, model, material });
    this.layers = [];
    this.detail = kFine;
    this.boxes = undefined;  // of cells
  }

  setDetail(detail) {
    this.detail = detail;
    for (const layer of this.layers) layer.setDetail(detail);
  }

  fill(numbers) {
    const cells = numbers.length > kFew ? this.cellsOf(numbers) : [numbers];
    while (this.layers.length < cells.length) {
      const layer = new Layer(this.parent, this.model, this.material, true);
      layer.setDetail(this.detail);
      this.layers.push(layer);
    }
    this.layers.forEach((layer, i) => {
      layer.isCulled = cells.length > 1;
      layer.begin();
      for (const number of cells[i] ?? []) layer.add(number, this.model.bodies[number].pose, 0, kFixed);
      layer.end();
    });
    if (this.boxes) {
      this.parent.remove(this.boxes);
      this.boxes.geometry.dispose();
      this.boxes.dispose();
    }
    this.boxes = cells.length > 1 ? this.boxesOfCells() : undefined;
  }

  // One for each cell, around all but the surfaces in it.
  boxesOfCells() {
    const geometry = new THREE.BoxGeometry(1, 1, 1);
    const boxes = new THREE.InstancedMesh(geometry, this.material, this.layers.length);
    const [red, green, blue] = kFixed.map((part) => kLight[part]);
    const matrix = new THREE.Matrix4();
    boxes.userData.bounds = this.layers.map((layer, cell) => {
      const bounds = new THREE.Box3();
      for (const mesh of layer.meshes) {
        if (mesh.userData.isSurface) continue;
        mesh.computeBoundingBox();
        bounds.union(mesh.boundingBox);
      }
      boxes.setColorAt(cell, new THREE.Color(red, green, blue));
      boxes.setMatrixAt(cell, matrix);
      return bounds;
    });
    boxes.frustumCulled = false;
    boxes.receiveShadow = true;
    this.parent.add(boxes);
    return boxes;
  }

  // Draws so many bodies, those near the eye, and boxes for the other cells. The eye is in the frame of the bodies.
  spare(eye, most) {
    if (!this.boxes) return;
    const { bounds } = this.boxes.userData;
    const order = bounds.map((box, cell) => [box.distanceToPoint(eye), cell]).sort(([a], [b]) => a - b);
    const matrix = new THREE.Matrix4();
    let [drawn, count] = [0, 0];
    for (const [, cell] of order) {
      const meshes = this.layers[cell].meshes.filter((mesh) => !mesh.userData.isSurface);
      for (const mesh of meshes) drawn += mesh.count;
      for (const mesh of meshes) mesh.visible = drawn <= most;
      if (drawn <= most || meshes.length === 0) continue;
      const size = bounds[cell].getSize(new THREE.Vector3());
      matrix.makeScale(size.x, size.y, size.z).setPosition(bounds[cell].getCenter(new THREE.Vector3()));
      this.boxes.setMatrixAt(count++, matrix);
    }
    this.boxes.count = count;
    this.boxes.instanceMatrix.needsUpdate = true;
  }

  // The bodies by cell of a grid over all of them.
  cellsOf(numbers) {
    const { bodies } = this.model;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    const places = new Float32Array(3 * numbers.length);
    for (let i = 0; i < numbers.length; ++i) {
      const { pose } = bodies[numbers[i]];
      for (let axis = 0; axis < 3; ++axis) {
        places[3 * i + axis] = pose[axis];
        low[axis] = Math.min(low[axis], pose[axis]);
        high[axis] = Math.max(high[axis], pose[axis]);
      }
    }
    const extents = low.map((least, axis) => high[axis] - least);
    const size = sizeOfCells(extents, numbers.length / kBodiesInCell);
    const [columns, rows] = extents.map((extent) => Math.floor(extent / size) + 1);
    const cells = new Map();
    for (let i = 0; i < numbers.length; ++i) {
      const [x, y, z] = [0, 1, 2].map((axis) => Math.floor((places[3 * i + axis] - low[axis]) / size));
      const cell = x + columns * (y + rows * z);
      if (!cells.has(cell)) cells.set(cell, []);
      cells.get(cell).push(numbers[i]);
    }
    return [...cells.values()];
  }

  get meshes() {
    return this.layers.flatMap((layer) => layer.meshes);
  }
}

// The edge of cubes of which about so many fill a box.
function sizeOfCells(extents, count) {
  let low = 0;
  let high = Math.max(...extents) || 1;
  for (let i = 0; i < 40; ++i) {
    const middle = (low + high) / 2;
    if (extents.reduce((product, extent) => product * (Math.floor(extent / middle) + 1), 1) > count) low = middle;
    else high = middle;
  }
  return high;
}
