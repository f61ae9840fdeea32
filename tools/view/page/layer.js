// Draws many bodies: one instanced mesh for all pieces that differ by place, size and color alone. Places are handed
// out anew each time that a layer is filled, so bodies come and go as they like.
import { geometryOf, kFine } from "scree/detail";
import * as THREE from "three";

export const kPoseLength = 7;  // numbers: position x, y, z, rotation x, y, z, w
const kPieceLength = 12;       // numbers: three columns of three, position x, y, z

// Columns of the matrix of a rotation, times a number each.
export function writeRotation(qx, qy, qz, qw, sx, sy, sz, m) {
  m[0] = sx * (1 - 2 * (qy * qy + qz * qz));
  m[1] = sx * 2 * (qx * qy + qz * qw);
  m[2] = sx * 2 * (qx * qz - qy * qw);
  m[3] = sy * 2 * (qx * qy - qz * qw);
  m[4] = sy * (1 - 2 * (qx * qx + qz * qz));
  m[5] = sy * 2 * (qy * qz + qx * qw);
  m[6] = sz * 2 * (qx * qz + qy * qw);
  m[7] = sz * 2 * (qy * qz - qx * qw);
  m[8] = sz * (1 - 2 * (qx * qx + qy * qy));
}

// Writes the matrix of a piece to a place of an array: four columns of four. `r`: the columns of its body's rotation.
function writeMatrix(r, px, py, pz, numbers, at, m, to) {
  const r0 = r[0], r1 = r[1], r2 = r[2], r3 = r[3], r4 = r[4], r5 = r[5], r6 = r[6], r7 = r[7], r8 = r[8];
  for (let column = 0; column < 4; ++column, at += 3, to += 4) {
    const x = numbers[at], y = numbers[at + 1], z = numbers[at + 2];
    m[to] = r0 * x + r3 * y + r6 * z;
    m[to + 1] = r1 * x + r4 * y + r7 * z;
    m[to + 2] = r2 * x + r5 * y + r8 * z;
    m[to + 3] = 0;
  }
  m[to - 4] += px;
  m[to - 3] += py;
  m[to - 2] += pz;
  m[to - 1] = 1;
}

// What a color of 0 to 255 is in linear light.
export const kLight = Float32Array.from({ length: 256 }, (_, i) => new THREE.Color().setRGB(i / 255, 0, 0, THREE.SRGBColorSpace).r);

// The pieces of all bodies, one behind the other as bodies come: of each its mesh, and its place in the body's frame
// with the columns of its rotation and scale.
class Pieces {
  constructor(bodies) {
    this.bodies = bodies;
    this.count = 0;
    this.known = 0;  // bodies
    this.first = new Uint32Array(1);  // by body; the next one's is behind its last
    this.meshes = new Uint32Array(0);
    this.numbers = new Float32Array(0);
  }

  // Takes the bodies that have come since the last time.
  update() {
    if (this.known >= this.bodies.length) return;
    let count = this.count;
    for (let i = this.known; i < this.bodies.length; ++i) count += this.bodies[i].pieceCount;
    this.first = grown(this.first, this.bodies.length + 1);
    this.meshes = grown(this.meshes, count);
    this.numbers = grown(this.numbers, kPieceLength * count);
    for (; this.known < this.bodies.length; ++this.known) {
      for (const [mesh, px, py, pz, qx, qy, qz, qw, sx, sy, sz] of this.bodies[this.known].shapes) {
        this.meshes[this.count] = mesh;
        const to = kPieceLength * this.count++;
        writeRotation(qx, qy, qz, qw, sx, sy, sz, this.numbers.subarray(to, to + 9));
        this.numbers.set([px, py, pz], to + 9);
      }
      this.first[this.known + 1] = this.count;
    }
  }
}

// An array with room for as many numbers, and for more to come.
function grown(array, length) {
  if (array.length >= length) return array;
  const larger = new array.constructor(Math.max(length, 2 * array.length));
  larger.set(array);
  return larger;
}

export class Layer {
  // `model` has the meshes and bodies, which may become more.
  constructor(parent, model, material, castsShadows) {
    this.parent = parent;
    this.model = model;
    this.material = material;
    this.castsShadows = castsShadows;
    this.pieces = (model.pieces ??= new Pieces(model.bodies));
    this.instances = [];  // by mesh number
    this.rotation = new Float32Array(9);
    this.detail = kFine;
    this.isCulled = false;  // whether meshes out of sight are left out: those that stay as they are
  }

  setDetail(detail) {
    this.detail = detail;
    this.instances.forEach((mesh, number) => { mesh.geometry = geometryOf(this.model.meshes[number], detail); });
  }

  begin() {
    this.pieces.update();
    for (const mesh of this.instances) if (mesh) mesh.count = 0;
  }

  // Room for one more.
  grow(number) {
    const old = this.instances[number];
    const capacity = old ? 2 * old.userData.capacity : 16;
    const mesh = new THREE.InstancedMesh(geometryOf(this.model.meshes[number], this.detail), this.material, capacity);
    mesh.instanceColor = new THREE.InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    for (const list of [mesh.instanceMatrix, mesh.instanceColor]) list.setUsage(THREE.DynamicDrawUsage);
    mesh.userData = { capacity, matrices: mesh.instanceMatrix.array, colors: mesh.instanceColor.array,
      bodies: new Int32Array(capacity), isSurface: this.model.meshes[number].isSurface };
    mesh.frustumCulled = this.isCulled;
    mesh.castShadow = mesh.receiveShadow = this.castsShadows;
    mesh.count = 0;
    if (old) {
      mesh.count = old.count;
      for (const list of ["matrices", "colors", "bodies"]) mesh.userData[list].set(old.userData[list]);
      this.parent.remove(old);
      old.dispose();
    }
    this.parent.add(mesh);
    this.instances[number] = mesh;
    return mesh;
  }

  // Adds a body whose pose begins at a place of an array.
  add(number, poses, at, color) {
    const { rotation } = this;
    const { first, meshes, numbers } = this.pieces;
    const px = poses[at], py = poses[at + 1], pz = poses[at + 2];
    writeRotation(poses[at + 3], poses[at + 4], poses[at + 5], poses[at + 6], 1, 1, 1, rotation);
    const end = first[number + 1];
    for (let piece = first[number]; piece < end; ++piece) {
      let mesh = this.instances[meshes[piece]];
      if (!mesh || mesh.count === mesh.userData.capacity) mesh = this.grow(meshes[piece]);
      const place = mesh.count++;
      const { matrices, colors, bodies } = mesh.userData;
      writeMatrix(rotation, px, py, pz, numbers, kPieceLength * piece, matrices, 16 * place);
      colors[3 * place] = kLight[color[0] | 0];
      colors[3 * place + 1] = kLight[color[1] | 0];
      colors[3 * place + 2] = kLight[color[2] | 0];
      bodies[place] = number;
    }
  }

  end() {
    for (const mesh of this.instances) {
      if (!mesh) continue;
      for (const list of [mesh.instanceMatrix, mesh.instanceColor]) {  // without the room that is left
        list.clearUpdateRanges();
        list.addUpdateRange(0, list.itemSize * mesh.count);
        list.needsUpdate = mesh.count > 0;
      }
      mesh.boundingSphere = null;  // who picks or culls makes it anew
      mesh.frustumCulled = this.isCulled;
      mesh.visible = mesh.count > 0;
    }
  }

  get meshes() {
    return this.instances.filter((mesh) => mesh && mesh.count > 0);
  }
}
