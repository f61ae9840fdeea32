// Draws many bodies: one instanced mesh for all pieces that differ by place, size and color alone. Places are handed
// out anew each time that a layer is filled, so bodies come and go as they like.
import { geometryOf, kFine } from "scree/detail";
import * as THREE from "three";

export const kPoseLength = 7;  // numbers: position x, y, z, rotation x, y, z, w

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

// What a color of 0 to 255 is in linear light.
const kLight = Float32Array.from({ length: 256 }, (_, i) => new THREE.Color().setRGB(i / 255, 0, 0, THREE.SRGBColorSpace).r);

// A body's pieces: of each the mesh, its place in the body's frame, and the columns of its rotation and scale.
function piecesOf(body) {
  if (!body.pieces) {
    body.pieces = body.shapes.map(([mesh, px, py, pz, qx, qy, qz, qw, sx, sy, sz]) => {
      const columns = new Float32Array(9);
      writeRotation(qx, qy, qz, qw, sx, sy, sz, columns);
      return { mesh, offset: [px, py, pz], columns };
    });
  }
  return body.pieces;
}

export class Layer {
  // `model` has the meshes and bodies, which may become more.
  constructor(parent, model, material, castsShadows) {
    this.parent = parent;
    this.model = model;
    this.material = material;
    this.castsShadows = castsShadows;
    this.instances = [];  // by mesh number
    this.rotation = new Float32Array(9);
    this.detail = kFine;
  }

  setDetail(detail) {
    this.detail = detail;
    this.instances.forEach((mesh, number) => { mesh.geometry = geometryOf(this.model.meshes[number], detail); });
  }

  begin() {
    for (const mesh of this.instances) if (mesh) mesh.count = 0;
  }

  // Room for one more.
  grow(number) {
    const old = this.instances[number];
    const capacity = old ? 2 * old.userData.capacity : 16;
    const mesh = new THREE.InstancedMesh(geometryOf(this.model.meshes[number], this.detail), this.material, capacity);
    mesh.instanceColor = new THREE.InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    mesh.userData = { capacity, bodies: new Int32Array(capacity), isSurface: this.model.meshes[number].isSurface };
    mesh.frustumCulled = false;
    mesh.castShadow = mesh.receiveShadow = this.castsShadows;
    mesh.count = 0;
    if (old) {
      mesh.count = old.count;
      mesh.instanceMatrix.array.set(old.instanceMatrix.array);
      mesh.instanceColor.array.set(old.instanceColor.array);
      mesh.userData.bodies.set(old.userData.bodies);
      this.parent.remove(old);
      old.dispose();
    }
    this.parent.add(mesh);
    this.instances[number] = mesh;
    return mesh;
  }

  // Adds a body whose pose begins at a place of an array.
  add(number, poses, at, [red, green, blue]) {
    const r = this.rotation;
    const px = poses[at], py = poses[at + 1], pz = poses[at + 2];
    writeRotation(poses[at + 3], poses[at + 4], poses[at + 5], poses[at + 6], 1, 1, 1, r);
    const [r1, g1, b1] = [kLight[red | 0], kLight[green | 0], kLight[blue | 0]];
    for (const { mesh: meshNumber, offset: o, columns: s } of piecesOf(this.model.bodies[number])) {
      let mesh = this.instances[meshNumber];
      if (!mesh || mesh.count === mesh.userData.capacity) mesh = this.grow(meshNumber);
      const place = mesh.count++;
      const m = mesh.instanceMatrix.array;
      const to = 16 * place;
      for (let column = 0; column < 3; ++column) {
        const x = s[3 * column], y = s[3 * column + 1], z = s[3 * column + 2];
        for (let row = 0; row < 3; ++row) m[to + 4 * column + row] = r[row] * x + r[3 + row] * y + r[6 + row] * z;
        m[to + 4 * column + 3] = 0;
      }
      m[to + 12] = px + r[0] * o[0] + r[3] * o[1] + r[6] * o[2];
      m[to + 13] = py + r[1] * o[0] + r[4] * o[1] + r[7] * o[2];
      m[to + 14] = pz + r[2] * o[0] + r[5] * o[1] + r[8] * o[2];
      m[to + 15] = 1;
      const c = mesh.instanceColor.array;
      c[3 * place] = r1;
      c[3 * place + 1] = g1;
      c[3 * place + 2] = b1;
      mesh.userData.bodies[place] = number;
    }
  }

  end() {
    for (const mesh of this.instances) {
      if (!mesh) continue;
      mesh.instanceMatrix.needsUpdate = true;
      mesh.instanceColor.needsUpdate = true;
      mesh.boundingSphere = null;  // picking asks for it
      mesh.visible = mesh.count > 0;
    }
  }

  get meshes() {
    return this.instances.filter((mesh) => mesh && mesh.count > 0);
  }
}
