// The page: loads the clip, shows it, and follows what the user does.
import { Clip } from "scree/clip";
import { Orbit } from "scree/orbit";
import { Plot } from "scree/plot";
import { Scene } from "scree/scene";

const element = (id) => document.getElementById(id);

function fail(text) {
  document.body.dataset.state = "error";
  element("message").textContent = text;
}

function number(value, digits = 4) {
  return Number.isFinite(value) ? Number(value.toPrecision(digits)).toLocaleString("en-US", { maximumFractionDigits: 6 }) : "–";
}

function list(target, rows) {
  target.replaceChildren(...rows.flatMap(([name, value]) => {
    const dt = document.createElement("dt");
    const dd = document.createElement("dd");
    dt.textContent = name;
    dd.textContent = value;
    return [dt, dd];
  }));
}

class Page {
  constructor(clip) {
    this.clip = clip;
    this.canvas = element("view");
    this.scene = new Scene(this.canvas, clip);
    this.orbit = new Orbit(this.scene.camera, this.canvas, this.scene.middle, this.scene.reach);
    this.time = 0;
    this.isPlaying = false;
    this.rate = 1;
    this.lastFrame = undefined;
    this.drawn = undefined;  // the state that is on the screen
    this.slowFrames = 0;
    this.graph = new Plot(element("graph"));
    this.chosenPlot = new Plot(element("chosen-plot"));
    element("time").max = clip.duration;
    this.listen();
    this.resize();
    requestAnimationFrame((now) => this.frame(now));
  }

  listen() {
    element("play").addEventListener("click", () => this.play(!this.isPlaying));
    element("back").addEventListener("click", () => this.step(-1));
    element("on").addEventListener("click", () => this.step(1));
    element("time").addEventListener("input", (event) => this.goTo(Number(event.target.value)));
    element("rate").addEventListener("change", (event) => { this.rate = Number(event.target.value); });
    element("colors").addEventListener("change", (event) => { this.scene.colorBy = event.target.value; });
    element("shadows").addEventListener("change", (event) => this.scene.setShadows(event.target.checked));
    element("grid").addEventListener("change", (event) => { this.scene.grid.visible = event.target.checked; });
    element("walls").addEventListener("change", (event) => { this.scene.keepsWalls = event.target.checked; });
    element("panel").addEventListener("change", () => { this.drawn = undefined; });
    element("follow").addEventListener("change", () => this.followChosen());
    window.addEventListener("resize", () => this.resize());
    window.addEventListener("keydown", (event) => this.key(event));
    let pressed;
    this.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("click", (event) => {
      const hasDragged = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4;
      if (!hasDragged) this.pick(event.clientX, event.clientY);
    });
    this.canvas.addEventListener("webglcontextlost", () => fail("The browser has lost the picture. Load the page again."));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // Controls keep what they use themselves; the arrows of the time are steps.
    if (event.target.tagName === "SELECT") return;
    if (event.key === " " && event.target !== this.canvas && event.target.id !== "time" && event.target !== document.body) return;
    const actions = {
      " ": () => this.play(!this.isPlaying),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
      Home: () => this.goTo(0),
      End: () => this.goTo(this.clip.duration),
      "[": () => this.changeRate(-1),
      "]": () => this.changeRate(1),
      w: () => (event.shiftKey ? this.orbit.pan(0, 40) : this.orbit.turn(0, 0.08)),
      s: () => (event.shiftKey ? this.orbit.pan(0, -40) : this.orbit.turn(0, -0.08)),
      a: () => (event.shiftKey ? this.orbit.pan(40, 0) : this.orbit.turn(-0.08, 0)),
      d: () => (event.shiftKey ? this.orbit.pan(-40, 0) : this.orbit.turn(0.08, 0)),
      q: () => this.orbit.zoom(1 / 1.1),
      e: () => this.orbit.zoom(1.1),
      n: () => this.chooseNext(1),
      p: () => this.chooseNext(-1),
      f: () => element("follow").click(),
      c: () => this.changeColors(),
      r: () => this.orbit.reset(),
    };
    const action = actions[event.key] ?? actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  }

  play(on) {
    if (on && this.time >= this.clip.duration) this.time = 0;
    this.isPlaying = on;
    this.lastFrame = undefined;
    element("play").textContent = on ? "Pause" : "Play";
    element("play").setAttribute("aria-label", on ? "Pause" : "Play");
  }

  goTo(time) {
    this.time = Math.min(this.clip.duration, Math.max(0, time));
  }

  // To the sample after or before the present one.
  step(by) {
    this.play(false);
    const sample = this.clip.sampleAt(this.time);
    const isBetween = this.time > this.clip.times[sample];
    const to = by < 0 && isBetween ? sample : sample + by;
    this.goTo(this.clip.times[Math.min(this.clip.times.length - 1, Math.max(0, to))]);
  }

  changeRate(by) {
    const field = element("rate");
    field.selectedIndex = Math.min(field.options.length - 1, Math.max(0, field.selectedIndex + by));
    this.rate = Number(field.value);
  }

  changeColors() {
    const field = element("colors");
    field.selectedIndex = (field.selectedIndex + 1) % field.options.length;
    this.scene.colorBy = field.value;
  }

  pick(x, y) {
    const box = this.canvas.getBoundingClientRect();
    this.choose(this.scene.pick((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height));
  }

  chooseNext(by) {
    const sample = this.clip.sampleAt(this.time);
    const isThere = (body) => sample >= body.first && sample < body.first + body.count;
    const movable = this.clip.bodies.map((body, i) => (body.type !== "fixed" && isThere(body) ? i : -1)).filter((i) => i >= 0);
    if (movable.length === 0) return;
    const at = movable.indexOf(this.scene.chosen);
    const next = at < 0 ? (by > 0 ? 0 : movable.length - 1) : (at + by + movable.length) % movable.length;
    this.choose(movable[next]);
  }

  choose(body) {
    this.scene.chosen = body;
    element("chosen").hidden = body < 0;
    if (body < 0) return;
    const { index, first, count } = this.clip.bodies[body];
    element("chosen-name").textContent = `Body ${index}`;
    this.speeds = this.clip.times.map((_, sample) =>
      sample >= first && sample < first + count ? this.clip.speedAt(this.clip.bodies[body], sample) : NaN);
  }

  followChosen() {
    if (!element("follow").checked || this.scene.chosen < 0) return;
    const center = this.scene.centerOf(this.scene.chosen, this.time);
    if (center) this.orbit.lookAt(center);
  }

  resize() {
    this.drawn = undefined;
    this.scene.resize(window.innerWidth, window.innerHeight);
  }

  frame(now) {
    if (this.isPlaying && this.lastFrame !== undefined) {
      const longest = 250;  // ms: a page that was hidden goes on where it was
      this.goTo(this.time + (this.rate * Math.min(longest, now - this.lastFrame)) / 1000);
      if (this.time >= this.clip.duration) this.play(false);
    }
    this.lastFrame = now;
    try {
      this.draw();
    } catch (error) {
      fail(`The page cannot go on drawing: ${error.message}`);
      return;
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  // Draws if anything has changed since the last time.
  draw() {
    this.followChosen();
    const eye = this.scene.camera.position;
    const state = [this.time, this.scene.chosen, this.scene.colorBy, eye.x, eye.y, eye.z, ...this.orbit.target,
      window.innerWidth, window.innerHeight].join();
    if (this.drawn === state) return;
    this.drawn = state;
    const start = performance.now();
    this.scene.show(this.time);
    this.scene.draw();
    this.tell();
    this.spare(performance.now() - start);
  }

  // Without a graphics card shadows cost more than half of the time.
  spare(milliseconds) {
    this.slowFrames = milliseconds > 150 ? this.slowFrames + 1 : 0;
    const shadows = element("shadows");
    if (this.slowFrames < 3 || !shadows.checked || this.hasSpared) return;
    this.hasSpared = true;
    shadows.checked = false;
    this.scene.setShadows(false);
    this.drawn = undefined;
  }

  // All that is written on the page.
  tell() {
    const sample = this.clip.sampleAt(this.time);
    const share = this.clip.duration > 0 ? this.time / this.clip.duration : 0;
    const text = `step ${this.clip.steps[sample].toLocaleString("en-US")}, ${this.time.toFixed(2)} s`;
    if (element("clock").textContent !== text) element("clock").textContent = text;
    element("time").value = this.time;
    element("time").setAttribute("aria-valuetext", text);
    const state = [sample, share, this.scene.chosen, window.innerWidth].join();
    if (this.told === state) return;
    this.told = state;
    const stats = this.clip.stats;
    list(element("world"), [
      ["bodies", number(stats.bodies[sample], 9)],
      ["awake", number(stats.awake[sample], 9)],
      ["contacts", number(stats.contacts[sample], 9)],
      ["kinetic energy", `${number(stats.energy[sample])} J`],
      ["lines of the grid", `${number(this.scene.spacing)} m`],
    ]);
    this.graph.draw(this.clip.times, [{ values: stats.contacts, color: "#7fb2e5" }, { values: stats.energy, color: "#f0a45a" }], share);
    if (this.scene.chosen < 0) return;
    const body = this.clip.bodies[this.scene.chosen];
    const pose = new Float32Array(7);
    const isThere = this.clip.poseAt(body, sample, 0, pose);
    list(element("chosen-figures"), [
      ["type", body.type],
      ["shapes", String(body.shape_count)],
      ["position", isThere ? [...pose.subarray(0, 3)].map((x) => x.toFixed(3)).join(", ") + " m" : "not there"],
      ["speed", isThere ? `${number(this.clip.speedAt(body, sample), 3)} m/s` : "–"],
    ]);
    this.chosenPlot.draw(this.clip.times, [{ values: this.speeds, color: "#f0a45a" }], share);
  }
}

async function begin() {
  if (document.body.dataset.state === "error") return;  // the browser is too old
  let clip;
  try {
    clip = await Clip.fromPage(document);
  } catch (error) {
    fail(`The animation in this page is damaged: ${error.message}`);
    return;
  }
  if (!document.createElement("canvas").getContext("webgl2")) {
    fail("This browser cannot draw the page: it has no WebGL 2, or it is turned off.");
    return;
  }
  try {
    window.screePage = new Page(clip);  // for scripts that drive the page
  } catch (error) {
    fail(`The page cannot be drawn: ${error.message}`);
    return;
  }
  document.body.dataset.state = "ready";
}

begin();
