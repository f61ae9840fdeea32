// Draws what a model shows: bodies that stand still, bodies that move, and pale ones of a second track.
//
// A model has `bodies` and `meshes`, which may become more, `up` and `size`; and gives states, see clip.js.
import { kBlue, kChosen, kFixed, kOrange, paletteColor, speedColor } from "scree/colors";
import { kCoarse, kFine } from "scree/detail";
import { Field } from "scree/field";
import { Layer, kPoseLength } from "scree/layer";
import { Walls } from "scree/walls";
import * as THREE from "three";

const kPale = [250, 250, 255];
const kShadowPixels = 2048;
const kMany = 10000;  // bodies: drawn coarsely
const kMostStanding = 2e6;
const kMostStandingWithoutCard = 5000;

// The middle of the shortest interval that holds a quarter of the values.
function densestOf(values) {
  const sorted = Float64Array.from(values).sort();
  if (sorted.length === 0) return 0;
  const count = Math.max(1, sorted.length >> 2);
  let best = 0;
  for (let i = 0; i + count < sorted.length; ++i) {
    if (sorted[i + count] - sorted[i] < sorted[best + count] - sorted[best]) best = i;
  }
  return sorted[best + (count >> 1)];
}

// How far most of the points are from the middle: where their number over the root of the distance is largest. Two
// heaps that are alike belong together up to four times their size apart.
function reachOf(points, middle, least) {
  const distances = Float64Array.from(points, (point) => Math.max(least, point.distanceTo(middle))).sort();
  let [best, reach] = [0, least];
  distances.forEach((distance, i) => {
    const share = (i + 1) / Math.sqrt(distance);
    if (share >= best) [best, reach] = [share, distance];
  });
  return reach;
}

export class Scene {
  // Throws where there is no WebGL. `states`: what the first view is about, at most four, the first one first.
  constructor(canvas, model, states) {
    this.model = model;
    // What is drawn stays, so that scripts can take pictures of it at any time.
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.hasCard = this.findCard();
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xbfc7ce);
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
    this.root = new THREE.Group();  // as the recorded world, whatever its up is
    this.root.quaternion.setFromUnitVectors(new THREE.Vector3(...model.up), new THREE.Vector3(0, 1, 0));
    this.root.updateMatrixWorld(true);
    this.scene.add(this.root);
    this.colorBy = "body";
    this.chosen = -1;
    this.keepsWalls = false;
    const solid = new THREE.MeshLambertMaterial();
    const pale = new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.35, depthWrite: false });
    this.standing = new Field(this.root, model, solid);
    this.moving = new Layer(this.root, model, solid, true);
    this.beside = new THREE.Group();  // of the second track
    this.root.add(this.beside);
    this.isSideBySide = false;
    this.pale = new Layer(this.beside, model, pale, false);
    this.second = new Layer(this.beside, model, solid, true);
    this.secondStanding = new Field(this.beside, model, solid);
    this.layers = [this.standing, this.moving, this.pale, this.second, this.secondStanding];
    this.standingKey = undefined;
    this.detail = kFine;
    this.measure(states);
    this.addLights();
    this.addGrid();
    if (states[0].numbers.length > kMany) this.setDetail(kCoarse);
  }

  // Where bodies are in a state.
  centersIn(state, isWanted) {
    const centers = [];
    for (let i = 0; i < state.numbers.length; ++i) {
      const body = this.model.bodies[state.numbers[i]];
      if (!isWanted(body) || body.pieceCount === 0) continue;
      centers.push(new THREE.Vector3().fromArray(state.poses, kPoseLength * i));
    }
    for (const number of state.standing) {
      const body = this.model.bodies[number];
      if (isWanted(body) && body.pieceCount > 0) centers.push(new THREE.Vector3(...body.pose.slice(0, 3)));
    }
    return centers;
  }

  // What the first view is about: what moves as it is first seen and where it goes, without what is far from where
  // most of it is. Where nothing moves, all bodies.
  measure(states) {
    const isMoving = (body) => body.type !== "fixed";
    let isWanted = isMoving;
    let first = [];
    for (const state of states) {
      if (first.length === 0) first = this.centersIn(state, isMoving);
    }
    if (first.length === 0) {
      isWanted = () => true;
      first = this.centersIn(states[0], isWanted);
    }
    const middle = new THREE.Vector3(...[0, 1, 2].map((axis) => densestOf(first.map((c) => c.getComponent(axis)))));
    const all = states.flatMap((state) => this.centersIn(state, isWanted));
    const limit = 2 * Math.max(reachOf(first, middle, this.model.size), reachOf(all, middle, this.model.size));
    const box = new THREE.Box3().expandByPoint(middle);
    for (const center of all) {
      if (center.distanceTo(middle) <= limit) box.expandByPoint(center);
    }
    box.expandByScalar(this.model.size);
    box.applyMatrix4(this.root.matrixWorld);
    this.middle = box.getCenter(new THREE.Vector3());
    this.reach = box.getSize(new THREE.Vector3()).length() / 2;
    this.floor = box.min.y;
    this.camera.far = this.reach * 200;
  }

  addLights() {
    this.scene.add(new THREE.HemisphereLight(0xe6eef8, 0x8a8680, 1.9));
    const sun = new THREE.DirectionalLight(0xfff4e0, 2.4);
    sun.castShadow = true;
    sun.shadow.mapSize.set(kShadowPixels, kShadowPixels);
    sun.shadow.bias = -0.0005;
    this.scene.add(sun, sun.target);
    this.sun = sun;
    this.aimSun(this.middle, 3.4 * this.reach);
  }

  // Shadows are cast around what the camera looks at, as far as is seen from its distance. They go on by whole
  // pixels and in steps of a factor, so that their edges stay where they are.
  aimSun(target, distance) {
    const { sun } = this;
    const most = (this.isSideBySide ? 2.2 : 1.4) * this.reach;
    const wanted = Math.min(most, Math.max(0.7 * distance, 10 * this.model.size));
    const half = most * Math.SQRT2 ** -Math.floor((2 * Math.log(most / wanted)) / Math.LN2 + 1e-6);
    const pixel = (2 * half) / kShadowPixels;
    const forward = new THREE.Vector3(-0.55, 0.9, 0.6).normalize();
    const right = new THREE.Vector3(0, 1, 0).cross(forward).normalize();
    const up = forward.clone().cross(right);
    const place = new THREE.Vector3();
    for (const axis of [right, up, forward]) place.addScaledVector(axis, pixel * Math.round(target.dot(axis) / pixel));
    const away = 2 * this.reach + half;
    sun.target.position.copy(place);
    sun.position.copy(place).addScaledVector(forward, away);
    sun.target.updateMatrixWorld();
    if (this.shadowHalf === half) return;
    this.shadowHalf = half;
    Object.assign(sun.shadow.camera, { left: -half, right: half, top: half, bottom: -half, near: 0.01 * half, far: 2 * away });
    sun.shadow.camera.updateProjectionMatrix();
    sun.shadow.normalBias = 5 * pixel;
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
    this.renderer.setPixelRatio(this.hasFewPixels ? 0.5 : Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    const transport = 96;  // pixels at the bottom, which the controls of time cover
    this.camera.setViewOffset(width, height, 0, transport / 2, width, height);
  }

  setFewPixels(on) {
    this.hasFewPixels = on;
    this.resize(window.innerWidth, window.innerHeight);
  }

  // Whether the processor does not draw itself.
  findCard() {
    const context = this.renderer.getContext();
    const about = context.getExtension("WEBGL_debug_renderer_info");
    const name = about ? String(context.getParameter(about.UNMASKED_RENDERER_WEBGL)) : "";
    return !/swiftshader|llvmpipe|software|basic render/i.test(name);
  }

  // Of what may move, in the i-th place of a state.
  colorOf(state, i) {
    const number = state.numbers[i];
    if (number === this.chosen) return kChosen;
    const body = this.model.bodies[number];
    if (body.type === "fixed") return kFixed;
    switch (this.colorBy) {
      case "body":
        return paletteColor(body.index);
      case "speed":
        return speedColor(state.speeds[i]);
      case "type":
        return body.type === "dynamic" ? kOrange : kBlue;
      case "sleep":
        return state.awake[i] ? kOrange : kBlue;
      default:
        return this.shade ? this.shade(state, i, body) : paletteColor(body.index);
    }
  }

  // Puts all bodies where they are in a state; `second`: the same of a track to compare with, or nothing.
  show(state, second) {
    this.state = state;
    if (this.standingKey !== state.standingKey) {
      this.standingKey = state.standingKey;
      this.walls = this.fill(this.standing, state.standing);
    }
    this.moving.begin();
    for (let i = 0; i < state.numbers.length; ++i)
      this.moving.add(state.numbers[i], state.poses, kPoseLength * i, this.colorOf(state, i));
    this.moving.end();
    this.showSecond(state, second);
    this.hideWalls(state);
    this.spareStanding();
  }

  spareStanding() {
    const most = this.drawsAll ? Infinity : this.hasCard ? kMostStanding : kMostStandingWithoutCard;
    const eye = this.root.worldToLocal(this.camera.position.clone());
    this.standing.spare(eye, most);
    this.secondStanding.spare(eye.sub(this.beside.position), most);
  }

  // Side by side it looks like the first one; over that it is pale where it is elsewhere.
  showSecond(state, second) {
    for (const layer of [this.pale, this.second]) layer.begin();
    if (second && this.isSideBySide) {
      for (let i = 0; i < second.numbers.length; ++i)
        this.second.add(second.numbers[i], second.poses, kPoseLength * i, this.colorOf(second, i));
    } else if (second) {
      for (let i = 0; i < second.numbers.length; ++i) {
        if (!this.isElsewhere(state, second, i)) continue;
        this.pale.add(second.numbers[i], second.poses, kPoseLength * i, kPale);
      }
    }
    for (const layer of [this.pale, this.second]) layer.end();
    const key = second && this.isSideBySide ? second.standingKey : "";
    if (this.secondKey === key) return;
    this.secondKey = key;
    this.secondWalls = this.fill(this.secondStanding, key ? second.standing : []);
  }

  // Whether the i-th body of the second state can be told from the same one of the first.
  isElsewhere(state, second, i) {
    if (state.numbers[i] !== second.numbers[i]) return true;
    let apart = 0;
    let turned = 0;
    for (let k = 0; k < kPoseLength; ++k) {
      const difference = Math.abs(state.poses[kPoseLength * i + k] - second.poses[kPoseLength * i + k]);
      if (k < 3) apart = Math.max(apart, difference);
      else turned = Math.max(turned, difference);
    }
    return apart > 0.02 * this.model.size || turned > 0.02;
  }

  // Moves the second track to the right of the first one, or back. Returns half of the way, in the scene's frame.
  setSideBySide(on) {
    this.isSideBySide = on;
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0);
    right.applyQuaternion(this.root.quaternion.clone().invert()).projectOnPlane(new THREE.Vector3(...this.model.up));
    const before = this.beside.position.clone();
    this.beside.position.copy(right.normalize().multiplyScalar(on ? 1.2 * this.reach : 0));
    this.beside.updateMatrixWorld(true);
    return this.beside.position.clone().sub(before).multiplyScalar(0.5).applyQuaternion(this.root.quaternion);
  }

  // Fills a field with bodies that stand still, which may be walls.
  fill(field, numbers) {
    field.fill(numbers);
    return new Walls(field, () => true);
  }

  hideWalls(state) {
    const places = this.keepsWalls ? [] : this.someMoving(state);
    if (places.length === 0) {
      this.walls.showAll();
      this.secondWalls?.showAll();
      return;
    }
    const eye = this.root.worldToLocal(this.camera.position.clone());
    const down = new THREE.Vector3(...this.model.up).multiplyScalar(-4 * this.reach);
    this.walls.hide(eye, places, down);
    this.secondWalls?.hide(eye.clone().sub(this.beside.position), places, down);
    if (this.hasKinematic(state))
      new Walls(this.moving, (number) => this.model.bodies[number].type === "kinematic").hide(eye, places, down);
  }

  hasKinematic({ numbers }) {
    if (this.numbers !== numbers) {  // the list of a frame stays the same
      this.numbers = numbers;
      this.isKinematicThere = numbers.some((number) => this.model.bodies[number].type === "kinematic");
    }
    return this.isKinematicThere;
  }

  // Where some of the dynamic bodies are: at equal strides they might all be of one column of a grid.
  someMoving({ numbers, poses }) {
    const kSome = 64;
    const kGolden = 0.6180339887498949;
    const places = [];
    const count = Math.min(kSome, numbers.length);
    for (let k = 0; k < count; ++k) {
      const i = numbers.length <= kSome ? k : Math.floor(((k * kGolden) % 1) * numbers.length);
      const body = this.model.bodies[numbers[i]];
      if (body.type === "dynamic" && body.pieceCount > 0) places.push(new THREE.Vector3().fromArray(poses, kPoseLength * i));
    }
    return places;
  }

  // How fine bodies are drawn, see detail.js; boxes without shadows.
  setDetail(detail) {
    this.detail = detail;
    this.drawsAll = false;
    for (const layer of this.layers) layer.setDetail(detail);
    this.standingKey = this.secondKey = undefined;  // they are filled anew, with all walls
  }

  // What is seen at a place of the picture, -1 to 1 to the right and up: the number of a body and the point, in
  // the world's frame. Nothing: no body.
  hit(x, y, others = []) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const [hit] = ray.intersectObjects([...this.moving.meshes, ...this.standing.meshes, ...others], false);
    if (!hit) return undefined;
    return { body: hit.object.userData.bodies[hit.instanceId], point: this.root.worldToLocal(hit.point.clone()) };
  }

  // The number of the body there, of either track; -1: none, or a fixed one.
  pick(x, y) {
    const body = this.hit(x, y, [...this.second.meshes, ...this.secondStanding.meshes])?.body ?? -1;
    return body >= 0 && this.model.bodies[body].type !== "fixed" ? body : -1;
  }

  // The eye and the direction of a place of the picture, in the world's frame.
  rayAt(x, y) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const turn = this.root.quaternion.clone().invert();
    return { from: this.root.worldToLocal(ray.ray.origin.clone()), toward: ray.ray.direction.clone().applyQuaternion(turn) };
  }

  // Where a body of a state is, in the scene's frame; nothing where it is not there.
  centerOf(number, state = this.state) {
    const at = state ? state.numbers.indexOf(number) : -1;
    if (at < 0) return undefined;
    return new THREE.Vector3().fromArray(state.poses, kPoseLength * at).applyMatrix4(this.root.matrixWorld);
  }

  setShadows(on) {
    this.sun.castShadow = on;
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }
}
