// Walls that hide what moves: fixed and kinematic shapes that stand between the eye and more than a tenth of it,
// unless they are the ground below it. Shapes are taken for the boxes around them; surfaces are left alone, as
// they are seen from their fronts only.
import { hide } from "scree/scene";
import * as THREE from "three";

const kMostSamples = 48;
const kMostWalls = 2000;
const kShare = 0.1;
const kBefore = 0.98;  // of the way to a body: what is farther off is what it lies on

// Whether the segment from a to b meets the box, both in the box's frame.
function meets(box, a, b) {
  let enters = 0;
  let leaves = kBefore;
  for (let axis = 0; axis < 3; ++axis) {
    const from = a.getComponent(axis);
    const way = b.getComponent(axis) - from;
    const low = box.min.getComponent(axis) - from;
    const high = box.max.getComponent(axis) - from;
    if (way === 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    enters = Math.max(enters, Math.min(low / way, high / way));
    leaves = Math.min(leaves, Math.max(low / way, high / way));
  }
  return enters <= leaves;
}

export class Walls {
  constructor(scene, clip) {
    this.scene = scene;
    this.clip = clip;
    this.walls = [];
    this.movers = [];
    clip.bodies.forEach((body, number) => {
      if (body.type === "dynamic") this.movers.push(number);
      else scene.instances[number].forEach((instance) => this.add(instance, number));
    });
    if (this.walls.length > kMostWalls) this.walls = [];
  }

  add(instance, number) {
    if (instance.isSurface) return;
    const geometry = instance.mesh.geometry;
    if (!geometry.boundingBox) geometry.computeBoundingBox();
    this.walls.push({ instance, number, box: geometry.boundingBox });
  }

  // Takes away the walls for an eye, in the frame of the recorded world. Call it when all instances have their
  // places.
  hide(eye, sample) {
    const stride = Math.max(1, Math.floor(this.movers.length / kMostSamples));
    const pose = new Float32Array(7);
    const places = [];
    for (let i = 0; i < this.movers.length; i += stride) {
      const body = this.clip.bodies[this.movers[i]];
      if (this.clip.poseAt(body, sample, 0, pose)) places.push(new THREE.Vector3(pose[0], pose[1], pose[2]));
    }
    if (places.length === 0) return;
    const down = new THREE.Vector3(...this.clip.up).multiplyScalar(-4 * this.scene.reach);
    const matrix = new THREE.Matrix4();
    const place = new THREE.Vector3();
    const below = new THREE.Vector3();
    const localEye = new THREE.Vector3();
    for (const { instance, number, box } of this.walls) {
      if (instance.mesh.userData.bodies[instance.place] !== number) continue;  // it is not there
      instance.mesh.getMatrixAt(instance.place, matrix);
      matrix.invert();
      localEye.copy(eye).applyMatrix4(matrix);
      let hidden = 0;
      let carried = 0;
      for (const each of places) {
        place.copy(each).applyMatrix4(matrix);
        below.copy(each).add(down).applyMatrix4(matrix);
        if (meets(box, localEye, place)) ++hidden;
        if (meets(box, place, below)) ++carried;
      }
      if (hidden > kShare * places.length && carried <= kShare * places.length) {
        hide(instance.mesh, instance.place);
      }
    }
  }
}
