// What the user does to the world: drags, shoots, deletes, changes settings.
import * as THREE from "three";

export class Touch {
  constructor(page, model) {
    this.page = page;
    this.model = model;
    this.tool = "look";
    this.hold = undefined;  // of a drag: the plane that it moves in, and the body
    const canvas = page.canvas;
    canvas.addEventListener("pointerdown", (event) => this.press(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event), { capture: true });
    for (const kind of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(kind, (event) => this.release(event), { capture: true });
    }
  }

  // -1 to 1 to the right and up.
  placeOf(event) {
    const box = this.page.canvas.getBoundingClientRect();
    return [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
  }

  send(what) {
    this.page.live.ask({ ask: "touch", track: this.page.trackHere(), step: this.page.stepNumber, running: this.model.isPlaying || this.page.live.isSettling, what });
  }

  press(event) {
    if (this.tool === "look" || event.button !== 0) return;
    event.stopPropagation();
    const [x, y] = this.placeOf(event);
    if (this.tool === "shoot") {
      this.shoot(x, y);
      return;
    }
    const hit = this.page.scene.hit(x, y);
    if (!hit) return;
    const body = this.model.bodies[hit.body];
    if (this.tool === "delete") {
      this.send({ kind: "delete", body: body.index });
      return;
    }
    if (body.type !== "dynamic") return;
    this.page.choose(hit.body);
    const { scene } = this.page;
    const normal = new THREE.Vector3();
    scene.camera.getWorldDirection(normal);
    normal.applyQuaternion(scene.root.quaternion.clone().invert());
    this.hold = { plane: new THREE.Plane().setFromNormalAndCoplanarPoint(normal, hit.point), body: hit.body,
      point: hit.point, local: this.localOf(hit) };
    this.page.canvas.setPointerCapture(event.pointerId);
    this.send({ kind: "drag", body: body.index, point: hit.point.toArray() });
    if (!this.model.isPlaying) this.page.play(true);
  }

  // The point in the frame of its body.
  localOf({ body, point }) {
    const { state } = this.page.scene;
    const at = state.numbers.indexOf(body);
    if (at < 0) return undefined;
    const turn = new THREE.Quaternion().fromArray(state.poses, 7 * at + 3).invert();
    return point.clone().sub(new THREE.Vector3().fromArray(state.poses, 7 * at)).applyQuaternion(turn);
  }

  move(event) {
    if (!this.hold) return;
    event.stopPropagation();
    const { from, toward } = this.page.scene.rayAt(...this.placeOf(event));
    const point = new THREE.Vector3();
    if (!new THREE.Ray(from, toward).intersectPlane(this.hold.plane, point)) return;
    this.hold.point = point;
    this.send({ kind: "move", to: point.toArray() });
  }

  release(event) {
    if (!this.hold) return;
    event.stopPropagation();
    this.hold = undefined;
    this.page.scene.marks.held = undefined;
    this.send({ kind: "release" });
  }

  // The line from the held point to where it is dragged.
  showHold(state) {
    if (!this.hold?.local) return;
    const at = state.numbers.indexOf(this.hold.body);
    if (at < 0) return;
    const turn = new THREE.Quaternion().fromArray(state.poses, 7 * at + 3);
    const held = this.hold.local.clone().applyQuaternion(turn).add(new THREE.Vector3().fromArray(state.poses, 7 * at));
    this.page.scene.marks.held = [held.toArray(), this.hold.point.toArray()];
  }

  shoot(x, y) {
    const { from, toward } = this.page.scene.rayAt(x, y);
    const radius = 0.5 * this.model.size;
    this.send({ kind: "shoot", from: from.toArray(), toward: toward.toArray(), radius, density: 2000,
      speed: Math.max(10, 4 * this.page.scene.reach) });
    if (!this.model.isPlaying) this.page.play(true);
  }

  deleteChosen() {
    const { chosen, state } = this.page.scene;
    // Another body may have the index of one that is gone.
    const body = state.numbers.includes(chosen) ? this.model.bodies[chosen] : undefined;
    if (body) this.send({ kind: "delete", body: body.index });
  }
}
