// Walls that hide what moves: fixed and kinematic shapes that stand between the eye and more than a tenth of it,
// unless they are the ground below it. Shapes are taken for the boxes around them; surfaces are left alone, as
// they are seen from their fronts only.
import * as THREE from "three";

const kMostWalls = 2000;
const kShare = 0.1;
const kBefore = 0.98;  // of the way to a body: what is farther off is what it lies on
// A point. The last number stays 1: three.js divides by it.
const kNothing = new THREE.Matrix4().set(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1);

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

// The shapes of a layer that may be walls; `isWall` tells by the body. Make them anew when the layer is filled.
export class Walls {
  constructor(layer, isWall) {
    this.walls = [];
    for (const mesh of layer.meshes) {
      if (mesh.userData.isSurface) continue;
      if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
      for (let place = 0; place < mesh.count && this.walls.length <= kMostWalls; ++place) {
        if (!isWall(mesh.userData.bodies[place])) continue;
        const matrix = new THREE.Matrix4();
        mesh.getMatrixAt(place, matrix);
        this.walls.push({ mesh, place, matrix, inverse: matrix.clone().invert(), isHidden: false });
      }
    }
    if (this.walls.length > kMostWalls) this.walls = [];
  }

  // Hides walls for an eye, and shows the others. `places`: some of the bodies that move; `down`: far below
  // them. All in the frame of the world.
  hide(eye, places, down) {
    const [place, below, localEye] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    for (const wall of this.walls) {
      const box = wall.mesh.geometry.boundingBox;
      localEye.copy(eye).applyMatrix4(wall.inverse);
      let hidden = 0;
      let carried = 0;
      for (const each of places) {
        place.copy(each).applyMatrix4(wall.inverse);
        below.copy(each).add(down).applyMatrix4(wall.inverse);
        if (meets(box, localEye, place)) ++hidden;
        if (meets(box, place, below)) ++carried;
      }
      this.set(wall, hidden > kShare * places.length && carried <= kShare * places.length);
    }
  }

  set(wall, isHidden) {
    if (wall.isHidden === isHidden) return;
    wall.isHidden = isHidden;
    wall.mesh.setMatrixAt(wall.place, isHidden ? kNothing : wall.matrix);
    wall.mesh.instanceMatrix.needsUpdate = true;
    wall.mesh.boundingSphere = null;  // it may be of those that were seen
  }

  showAll() {
    for (const wall of this.walls) this.set(wall, false);
  }
}
