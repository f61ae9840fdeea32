// Draws the bodies of a clip: one instanced mesh for all shapes that differ by place, size and color alone. Rounded
// boxes and hulls have meshes of their own.
import { Walls } from "scree/walls";
import * as THREE from "three";

const kPalette = [[226, 138, 66], [86, 140, 196], [206, 96, 86], [112, 168, 92], [232, 190, 84], [124, 112, 176],
  [84, 168, 164], [214, 140, 160], [160, 122, 92], [150, 186, 210], [178, 196, 110], [222, 168, 132]];
const kFixed = [168, 170, 172];
const kOrange = [226, 138, 66];
const kBlue = [86, 140, 196];
const kChosen = [255, 255, 120];
// Matplotlib's viridis at 0, 1/4, 1/2, 3/4 and 1.
const kViridis = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

function speedColor(speed) {
  const share = 4 * Math.min(1, (speed / (speed + 3)) * (23 / 20));
  const low = Math.min(3, Math.floor(share));
  return [0, 1, 2].map((i) => kViridis[low][i] + (share - low) * (kViridis[low + 1][i] - kViridis[low][i]));
}

function geometryOf(mesh) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(mesh.positions, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(mesh.normals, 3));
  geometry.setIndex(new THREE.BufferAttribute(mesh.indices, 1));
  return geometry;
}

// Columns of the matrix of a rotation, times a number each.
function writeRotation(qx, qy, qz, qw, sx, sy, sz, m) {
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

// To a point. The last number stays 1: three.js divides by it.
export function hide(mesh, place) {
  const m = mesh.instanceMatrix.array;
  m.fill(0, 16 * place, 16 * place + 15);
  m[16 * place + 15] = 1;
}

// Places of a mesh's instances, handed out for spans of samples whose beginnings ascend.
class Places {
  constructor() {
    this.count = 0;
    this.free = [];
    this.ending = new Map();  // by sample: the places that are free from then on
    this.sample = 0;
  }

  take(first, end) {
    while (this.sample < first) {
      this.sample += 1;
      this.free.push(...(this.ending.get(this.sample) ?? []));
    }
    const place = this.free.pop() ?? this.count++;
    if (!this.ending.has(end)) this.ending.set(end, []);
    this.ending.get(end).push(place);
    return place;
  }
}

export class Scene {
  // Throws where there is no WebGL.
  constructor(canvas, clip) {
    this.clip = clip;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xbfc7ce);
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
    this.root = new THREE.Group();  // as the recorded world, whatever its up is
    this.root.quaternion.setFromUnitVectors(new THREE.Vector3(...clip.up), new THREE.Vector3(0, 1, 0));
    this.root.updateMatrixWorld(true);
    this.scene.add(this.root);
    this.colorBy = "body";
    this.chosen = -1;
    this.pose = new Float32Array(7);
    this.rotation = new Float32Array(9);
    this.addInstances();
    this.measure();
    this.walls = new Walls(this, clip);
    this.keepsWalls = false;
    this.addLights();
    this.addGrid();
  }

  // Bodies whose lives do not overlap share the places of their shapes.
  addInstances() {
    const places = this.clip.meshes.map(() => new Places());
    this.instances = this.clip.bodies.map((body) => body.shapes.map((shape) => {
      const [mesh, px, py, pz, qx, qy, qz, qw, sx, sy, sz] = shape;
      const columns = new Float32Array(9);
      writeRotation(qx, qy, qz, qw, sx, sy, sz, columns);
      const place = places[mesh].take(body.first, body.first + body.count);
      return { meshNumber: mesh, place, offset: [px, py, pz], columns, isSurface: this.clip.meshes[mesh].isSurface };
    }));
    const material = new THREE.MeshLambertMaterial();
    this.meshes = this.clip.meshes.map((mesh, i) => {
      const { count } = places[i];
      const instances = new THREE.InstancedMesh(geometryOf(mesh), material, Math.max(1, count));
      instances.instanceColor = new THREE.InstancedBufferAttribute(new Float32Array(3 * Math.max(1, count)), 3);
      instances.count = count;
      instances.frustumCulled = false;
      instances.castShadow = instances.receiveShadow = true;
      instances.userData.bodies = new Int32Array(count).fill(-1);  // who is at a place now
      this.root.add(instances);
      return instances;
    });
    for (const shapes of this.instances) {
      for (const instance of shapes) instance.mesh = this.meshes[instance.meshNumber];
    }
  }

  // Where bodies are at a sample.
  centersAt(sample, isWanted) {
    const centers = [];
    for (const body of this.clip.bodies) {
      if (!isWanted(body) || body.shapes.length === 0) continue;
      if (this.clip.poseAt(body, sample, 0, this.pose)) centers.push(new THREE.Vector3(...this.pose.subarray(0, 3)));
    }
    return centers;
  }

  // What the first view is about: what moves as it is first seen, without what is far from all the rest, and
  // where it goes, unless that is far off and not where half of it goes. Where nothing moves, all bodies.
  measure() {
    const last = this.clip.times.length - 1;
    const samples = [0, last >> 2, last >> 1, last];
    const isMoving = (body) => body.type !== "fixed";
    let isWanted = isMoving;
    let first = [];
    for (const sample of samples) {
      if (first.length === 0) first = this.centersAt(sample, isMoving);
    }
    if (first.length === 0) {
      isWanted = () => true;
      first = this.centersAt(0, isWanted);
    }
    const sorted = [0, 1, 2].map((axis) => first.map((c) => c.getComponent(axis)).sort((a, b) => a - b));
    const middle = new THREE.Vector3(...sorted.map((values) => values[values.length >> 1] ?? 0));
    const all = samples.flatMap((sample) => this.centersAt(sample, isWanted));
    const distanceOf = (centers, share) => {
      const distances = centers.map((c) => c.distanceTo(middle)).sort((a, b) => a - b);
      return distances[Math.floor(share * distances.length)] ?? 0;
    };
    const limit = 4 * Math.max(distanceOf(first, 0.9), distanceOf(all, 0.5), this.clip.size);
    const box = new THREE.Box3().expandByPoint(middle);
    for (const center of all) {
      if (center.distanceTo(middle) <= limit) box.expandByPoint(center);
    }
    box.expandByScalar(this.clip.size);
    box.applyMatrix4(this.root.matrixWorld);
    this.middle = box.getCenter(new THREE.Vector3());
    this.reach = box.getSize(new THREE.Vector3()).length() / 2;
    this.floor = box.min.y;
    this.camera.near = this.reach / 500;
    this.camera.far = this.reach * 200;
  }

  addLights() {
    this.scene.add(new THREE.HemisphereLight(0xe6eef8, 0x8a8680, 1.9));
    const sun = new THREE.DirectionalLight(0xfff4e0, 2.4);
    sun.position.copy(this.middle).add(new THREE.Vector3(-0.55, 0.9, 0.6).multiplyScalar(3 * this.reach));
    sun.target.position.copy(this.middle);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -1.4 * this.reach, right: 1.4 * this.reach, top: 1.4 * this.reach,
      bottom: -1.4 * this.reach, near: 0.1 * this.reach, far: 8 * this.reach });
    sun.shadow.normalBias = this.reach / 200;
    sun.shadow.bias = -0.0005;
    this.scene.add(sun, sun.target);
    this.sun = sun;
  }

  // Lines 0.1, 1, 10 ... m apart, at the height of the lowest body.
  addGrid() {
    const spacing = Math.pow(10, Math.ceil(Math.log10(0.15 * this.reach)));
    const lines = 40;
    this.grid = new THREE.GridHelper(lines * spacing, lines, 0x59636c, 0x8d98a1);
    this.grid.position.set(spacing * Math.round(this.middle.x / spacing), this.floor - this.reach / 1000,
      spacing * Math.round(this.middle.z / spacing));
    this.scene.add(this.grid);
    this.spacing = spacing;
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    const transport = 96;  // pixels at the bottom, which the controls of time cover
    this.camera.setViewOffset(width, height, 0, transport / 2, width, height);
  }

  colorOf(number, sample) {
    if (number === this.chosen) return kChosen;
    const body = this.clip.bodies[number];
    if (body.type === "fixed") return kFixed;
    if (this.colorBy === "speed") return speedColor(this.clip.speedAt(body, sample));
    if (this.colorBy === "type") return body.type === "dynamic" ? kOrange : kBlue;
    return kPalette[(5 * body.index) % kPalette.length];
  }

  // Puts all bodies where they are at a time.
  show(time) {
    const [sample, share] = this.clip.stateAt(time);
    const color = new THREE.Color();
    for (const mesh of this.meshes) mesh.userData.bodies.fill(-1);
    for (let number = 0; number < this.clip.bodies.length; ++number) {
      if (!this.clip.poseAt(this.clip.bodies[number], sample, share, this.pose)) continue;
      const [r, g, b] = this.colorOf(number, sample);
      color.setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace);
      for (const instance of this.instances[number]) this.place(instance, number, color);
    }
    for (const mesh of this.meshes) {
      mesh.userData.bodies.forEach((body, place) => {
        if (body < 0) hide(mesh, place);
      });
    }
    if (!this.keepsWalls) {
      const eye = this.root.worldToLocal(this.camera.position.clone());
      this.walls.hide(eye, sample);
    }
    for (const mesh of this.meshes) {
      mesh.instanceMatrix.needsUpdate = true;
      mesh.instanceColor.needsUpdate = true;
      mesh.boundingSphere = null;  // picking asks for it
    }
  }

  place(instance, number, color) {
    const m = instance.mesh.instanceMatrix.array;
    const at = 16 * instance.place;
    const [px, py, pz, qx, qy, qz, qw] = this.pose;
    const r = this.rotation;
    const s = instance.columns;
    const o = instance.offset;
    writeRotation(qx, qy, qz, qw, 1, 1, 1, r);
    for (let column = 0; column < 3; ++column) {
      for (let row = 0; row < 3; ++row) {
        m[at + 4 * column + row] = r[row] * s[3 * column] + r[3 + row] * s[3 * column + 1] + r[6 + row] * s[3 * column + 2];
      }
      m[at + 4 * column + 3] = 0;
    }
    m[at + 12] = px + r[0] * o[0] + r[3] * o[1] + r[6] * o[2];
    m[at + 13] = py + r[1] * o[0] + r[4] * o[1] + r[7] * o[2];
    m[at + 14] = pz + r[2] * o[0] + r[5] * o[1] + r[8] * o[2];
    m[at + 15] = 1;
    instance.mesh.instanceColor.setXYZ(instance.place, color.r, color.g, color.b);
    instance.mesh.userData.bodies[instance.place] = number;
  }

  // The number of the body at a place of the picture, -1 to 1 to the right and up; -1: none, or a fixed one.
  pick(x, y) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const [hit] = ray.intersectObjects(this.meshes, false);
    const body = hit ? hit.object.userData.bodies[hit.instanceId] : -1;
    return body >= 0 && this.clip.bodies[body].type !== "fixed" ? body : -1;
  }

  // Where a body is, in the scene's frame; nothing where it is not there.
  centerOf(number, time) {
    const [sample, share] = this.clip.stateAt(time);
    if (!this.clip.poseAt(this.clip.bodies[number], sample, share, this.pose)) return undefined;
    return new THREE.Vector3(this.pose[0], this.pose[1], this.pose[2]).applyMatrix4(this.root.matrixWorld);
  }

  setShadows(on) {
    this.sun.castShadow = on;
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }
}
