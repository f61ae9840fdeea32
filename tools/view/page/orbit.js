// A camera that goes round a target, or flies: by dragging, by the wheel, by touch and by keys. Flying turns about
// the eye, and the wheel moves it.
import * as THREE from "three";

export class Orbit {
  // `reach`: m, of all that is of interest; `size`: m, of a body.
  constructor(camera, canvas, middle, reach, size) {
    this.camera = camera;
    this.canvas = canvas;
    this.size = size;
    this.home = { target: middle.clone(), distance: 3.4 * reach, azimuth: 0.5, elevation: 0.37 };
    this.reach = reach;
    this.isFlying = false;
    this.reset();
    this.pointers = new Map();
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.release(event));
    canvas.addEventListener("pointercancel", (event) => this.release(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(0.001 * event.deltaY));
    }, { passive: false });
  }

  reset() {
    Object.assign(this, this.home, { target: this.home.target.clone() });
    this.update();
  }

  press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  release(event) {
    this.pointers.delete(event.pointerId);
  }

  move(event) {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    const dx = event.clientX - last[0];
    const dy = event.clientY - last[1];
    if (this.pointers.size === 2) {  // two fingers: nearer and farther
      const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const before = Math.hypot(last[0] - other[0], last[1] - other[1]);
      const after = Math.hypot(event.clientX - other[0], event.clientY - other[1]);
      if (before > 0 && after > 0) this.zoom(before / after);
      this.pan(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) {
      this.pan(dx, dy);
    } else {
      this.turn(-0.006 * dx, 0.006 * dy);
    }
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  turn(around, above) {
    const eye = this.camera.position.clone();
    this.azimuth += this.isFlying ? -around : around;
    this.elevation = Math.min(1.55, Math.max(-1.55, this.elevation + (this.isFlying ? -above : above)));
    this.update();
    if (!this.isFlying) return;
    this.target.add(eye.sub(this.camera.position));
    this.update();
  }

  // Forward by a share of the reach.
  advance(share) {
    const ahead = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 2);
    this.target.addScaledVector(ahead, -share * this.reach);
    this.update();
  }

  zoom(factor) {
    if (this.isFlying) return this.advance(-Math.log(factor));
    this.distance = Math.min(50 * this.reach, Math.max(Math.min(0.02 * this.reach, 2 * this.size), factor * this.distance));
    this.update();
    return undefined;
  }

  pan(dx, dy) {
    const scale = (2 * this.distance * Math.tan((this.camera.fov * Math.PI) / 360)) / this.canvas.clientHeight;
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 1);
    this.target.addScaledVector(right, -scale * dx).addScaledVector(up, scale * dy);
    this.update();
  }

  lookAt(target) {
    this.target.copy(target);
    this.update();
  }

  update() {
    // Nearer things are not drawn: as far off as the depths of far ones can still be told.
    const away = this.isFlying ? 0.1 * this.reach : this.distance;
    this.camera.near = Math.max(Math.min(away / 500, this.reach / 500), this.size / 500);
    this.camera.updateProjectionMatrix();
    const flat = Math.cos(this.elevation);
    this.camera.position.set(Math.sin(this.azimuth) * flat, Math.sin(this.elevation), Math.cos(this.azimuth) * flat)
      .multiplyScalar(this.distance).add(this.target);
    this.camera.lookAt(this.target);
    this.camera.updateMatrix();
    this.camera.updateMatrixWorld();
  }
}
