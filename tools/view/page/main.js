// The page: loads what it is to show, shows it, and follows what the user does.
import { Clip } from "scree/clip";
import { kScales } from "scree/colors";
import { kBoxes, kCoarse, kFine } from "scree/detail";
import { Live } from "scree/live";
import { LiveControls } from "scree/controls";
import { Marks } from "scree/marks";
import { Orbit } from "scree/orbit";
import { Plot } from "scree/plot";
import { Scene } from "scree/scene";
import { element, list, number } from "scree/text";

function fail(text) {
  document.body.dataset.state = "error";
  element("message").textContent = text;
}

// Keys that go on as long as they are held.
const kRepeated = ["arrowleft", "arrowright", "w", "a", "s", "d", "q", "e", "n", "p", "[", "]", ",", "."];

class Page {
  // `states`: what the first view is about.
  constructor(model, states) {
    this.model = model;
    this.canvas = element("view");
    this.scene = new Scene(this.canvas, model, states);
    this.scene.marks = new Marks(this.scene, model);
    this.orbit = new Orbit(this.scene.camera, this.canvas, this.scene.middle, this.scene.reach, model.size);
    this.time = 0;
    this.isPlaying = false;
    this.rate = 1;
    this.lastFrame = undefined;
    this.drawn = undefined;  // the state that is on the screen
    this.pictures = this.pictureTime = 0;  // since it was last known how long they take
    this.graph = new Plot(element("graph"));
    this.chosenPlot = new Plot(element("chosen-plot"));
    this.live = model.isLive ? new LiveControls(this, model) : undefined;
    this.listen();
    this.resize();
    this.spareAtFirst(states[0].numbers.length + states[0].standing.length);
    requestAnimationFrame((now) => this.frame(now));
  }

  listen() {
    element("play").addEventListener("click", () => this.play(!this.isPlaying));
    element("back").addEventListener("click", () => this.step(-1));
    element("on").addEventListener("click", () => this.step(1));
    element("time").addEventListener("input", (event) => this.goTo(Number(event.target.value)));
    element("rate").addEventListener("change", (event) => { this.rate = Number(event.target.value); });
    element("colors").addEventListener("change", (event) => this.setColors(event.target.value));
    element("shadows").addEventListener("change", (event) => this.scene.setShadows(event.target.checked));
    element("grid").addEventListener("change", (event) => { this.scene.grid.visible = event.target.checked; });
    element("walls").addEventListener("change", (event) => { this.scene.keepsWalls = event.target.checked; });
    element("fine").addEventListener("change", (event) => {
      if (event.target.checked) this.drawFinely();
    });
    element("fly").addEventListener("change", (event) => { this.orbit.isFlying = event.target.checked; });
    element("marks").addEventListener("change", () => {
      const boxes = element("marks").querySelectorAll("input:checked");
      this.scene.marks.shown = new Set([...boxes].map(({ value }) => value));
    });
    element("panel").addEventListener("change", () => { this.drawn = undefined; });
    element("follow").addEventListener("change", () => this.followChosen());
    window.addEventListener("resize", () => this.resize());
    window.addEventListener("keydown", (event) => this.key(event));
    let pressed;
    this.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("click", (event) => {
      const hasDragged = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4;
      if (!hasDragged && (!this.live || this.live.touch.tool === "look")) this.pick(event.clientX, event.clientY);
    });
    this.canvas.addEventListener("webglcontextlost", () => fail("The browser has lost the picture. Load the page again."));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // Controls keep what they use themselves; the arrows of the time are steps.
    if (event.target.tagName === "SELECT" || ["text", "number"].includes(event.target.type)) return;
    if (event.target.type === "radio" && event.key.startsWith("Arrow")) return;
    if (event.repeat && !kRepeated.includes(event.key.toLowerCase())) return;
    if (event.key === " " && event.target !== this.canvas && event.target.id !== "time" && event.target !== document.body) return;
    const turnOr = (x, y) => (event.shiftKey ? this.orbit.pan(-40 * x, 40 * y) : this.orbit.turn(0.08 * x, 0.08 * y));
    const actions = {
      " ": () => this.play(!this.isPlaying),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
      Home: () => this.goTo(0),
      End: () => this.goTo(this.live ? this.model.timeOf(this.model.last - this.model.first) : this.model.duration),
      "[": () => this.changeRate(-1),
      "]": () => this.changeRate(1),
      w: () => turnOr(0, 1),
      s: () => turnOr(0, -1),
      a: () => turnOr(-1, 0),
      d: () => turnOr(1, 0),
      q: () => this.orbit.zoom(1 / 1.1),
      e: () => this.orbit.zoom(1.1),
      v: () => element("fly").click(),
      n: () => this.chooseNext(1),
      p: () => this.chooseNext(-1),
      f: () => element("follow").click(),
      c: () => this.changeColors(),
      r: () => this.orbit.reset(),
      ...this.live?.keys,
    };
    const action = actions[event.key] ?? actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  }

  get sample() {
    return this.model.sampleAt(this.time);
  }

  get stepNumber() {
    return this.model.stepOf(this.sample);
  }

  play(on) {
    if (on && this.time >= this.model.duration && !this.live?.goesOn) this.time = 0;
    this.isPlaying = this.model.isPlaying = on;
    this.lastFrame = undefined;
    element("play").textContent = on ? "Pause" : "Play";
    element("play").setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) this.live?.settle();
  }

  goTo(time) {
    this.time = Math.min(this.model.duration, Math.max(0, time));
    if (this.live) this.live.isSettling = false;
  }

  goToSample(sample) {
    this.goTo(this.model.timeOf(Math.min(this.model.samples - 1, Math.max(0, sample))));
  }

  // To the sample after or before the present one.
  step(by) {
    this.play(false);
    const { sample } = this;
    const isBetween = this.time > this.model.timeOf(sample) + 1e-9;
    if (by > 0 && this.live?.stepOn(sample)) return;
    this.goToSample(by < 0 && isBetween ? sample : sample + by);
  }

  changeRate(by) {
    const field = element("rate");
    field.selectedIndex = Math.min(field.options.length - 1, Math.max(0, field.selectedIndex + by));
    this.rate = Number(field.value);
  }

  changeColors() {
    const options = [...element("colors").options].filter((option) => this.live || !option.classList.contains("live"));
    const at = options.findIndex(({ value }) => value === this.scene.colorBy);
    element("colors").value = options[(at + 1) % options.length].value;
    this.setColors(element("colors").value);
  }

  setColors(by) {
    this.scene.colorBy = by;
    element("scale").textContent = kScales[by] ?? "";
    this.live?.setColors(by);
    this.drawn = undefined;
  }

  pick(x, y) {
    const box = this.canvas.getBoundingClientRect();
    this.choose(this.scene.pick((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height));
  }

  chooseNext(by) {
    const movable = [...this.scene.state.numbers].filter((each) => this.model.bodies[each].type !== "fixed");
    if (movable.length === 0) return;
    const at = movable.indexOf(this.scene.chosen);
    const next = at < 0 ? (by > 0 ? 0 : movable.length - 1) : (at + by + movable.length) % movable.length;
    this.choose(movable[next]);
  }

  choose(body) {
    this.scene.chosen = body;
    element("chosen").hidden = body < 0;
    this.live?.choose();
    if (body < 0) return;
    element("chosen-name").textContent = `Body ${this.model.bodies[body].index}`;
    if (!this.live) this.speeds = this.model.speedsOf(body);
  }

  followChosen(state) {
    if (!element("follow").checked || this.scene.chosen < 0) return;
    const center = this.scene.centerOf(this.scene.chosen, state);
    if (center) this.orbit.lookAt(center);
  }

  resize() {
    this.drawn = undefined;
    this.scene.resize(window.innerWidth, window.innerHeight);
  }

  frame(now) {
    this.pace = 0;
    if (this.isPlaying && this.lastFrame !== undefined) {
      const longest = 250;  // ms: a page that was hidden goes on where it was
      this.pace = (this.rate * Math.min(longest, now - this.lastFrame)) / 1000;
      const next = this.time + this.pace;
      this.live?.extend(next);
      this.goTo(this.model.reachable(this.time, next));
      if (this.time >= this.model.duration && !this.live?.goesOn) this.play(false);
    }
    if (this.hasDrawn && this.lastFrame !== undefined) this.spare(now - this.lastFrame);
    this.lastFrame = now;
    this.hasDrawn = false;
    try {
      this.live?.update();
      this.draw();
    } catch (error) {
      fail(`The page cannot go on drawing: ${error.message}`);
      throw error;
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  // Draws if anything has changed since the last time.
  draw() {
    const eye = this.scene.camera.position;
    const seen = [this.time, this.scene.chosen, this.scene.colorBy, eye.x, eye.y, eye.z, ...this.orbit.target,
      window.innerWidth, window.innerHeight, this.model.version, this.live?.seen].join();
    if (this.drawn === seen) return;
    const state = this.model.state(this.time);
    if (!state) return;
    this.drawn = seen;
    this.hasDrawn = true;
    this.followChosen(state);
    this.scene.aimSun(this.orbit.target, this.orbit.distance);
    this.scene.show(state, this.live?.secondState());
    this.live?.touch.showHold(state);
    this.scene.marks.draw(state);
    this.scene.draw();
    this.tell(state);
  }

  // Draws less where it is slow, as without a graphics card: no shadows, which cost more than half of the time, then
  // fewer pixels and coarser bodies. What the user turns on again stays on.
  //
  // Pictures are made behind the page's back, some at once: the mean of several tells how long one takes.
  spare(milliseconds) {
    const kSlow = this.scene.hasCard ? 50 : 150;
    const kVerySlow = 1000;  // as 50,000 bodies without a card
    if (element("fine").checked) return;
    this.pictures += 1;
    this.pictureTime += milliseconds;
    if (this.pictures < 6 && this.pictureTime < 3000) return;
    const mean = this.pictureTime / this.pictures;
    this.pictures = this.pictureTime = 0;
    if (mean < kSlow) return;
    this.dropShadows();
    if (mean > 2 * kSlow && this.scene.detail < kBoxes) this.drawCoarsely(mean > kVerySlow ? kBoxes : this.scene.detail + 1);
  }

  dropShadows() {
    if (!element("shadows").checked || this.hasSpared) return;
    element("shadows").checked = false;
    this.scene.setShadows(false);
    this.hasSpared = true;
  }

  drawCoarsely(detail) {
    this.scene.setDetail(detail);
    if (detail === kBoxes) this.scene.setFewPixels(true);
    element("detail").hidden = false;
    this.drawn = undefined;
  }

  drawFinely() {
    this.scene.setDetail(kFine);
    this.scene.drawsAll = true;
    this.scene.setFewPixels(false);
    element("shadows").checked = true;
    this.scene.setShadows(true);
    element("detail").hidden = true;
    this.hasSpared = false;
    this.drawn = undefined;
  }

  // Without a card what will be slow is known before.
  spareAtFirst(bodies) {
    if (this.scene.hasCard) return;
    if (bodies > 1500) this.dropShadows();
    if (bodies > 2000) this.drawCoarsely(bodies > 6000 ? kBoxes : kCoarse);
  }

  // All that is written on the page.
  tell(state) {
    const { sample } = this;
    const share = this.model.duration > 0 ? this.time / this.model.duration : 0;
    const waits = this.model.isWaiting ? " …" : "";
    const text = `step ${this.model.stepOf(sample).toLocaleString("en-US")}, ${this.time.toFixed(2)} s${waits}`;
    if (element("clock").textContent !== text) element("clock").textContent = text;
    element("time").max = this.model.duration;
    element("time").value = this.time;
    element("time").setAttribute("aria-valuetext", text);
    const figures = this.model.figures(sample) ?? {};
    list(element("world"), [
      ["bodies", number(figures.bodies, 9)],
      ["awake", number(figures.awake, 9)],
      ["contacts", number(figures.contacts, 9)],
      ["kinetic energy", `${number(figures.energy)} J`],
      ...(this.live?.worldRows(figures) ?? []),
      ["lines of the grid", `${number(this.scene.spacing)} m`],
    ]);
    if (this.live) {
      this.live.drawTimeline(this.graph, share);
    } else {
      const { series } = this.model;
      this.graph.draw(series.times, [{ values: series.contacts, color: "#7fb2e5" }, { values: series.energy, color: "#f0a45a" }], share);
    }
    if (this.scene.chosen >= 0) this.tellChosen(state, share);
  }

  tellChosen(state, share) {
    const body = this.model.bodies[this.scene.chosen];
    const at = state.numbers.indexOf(this.scene.chosen);
    const isThere = at >= 0;
    list(element("chosen-figures"), [
      ["type", body.type],
      ["shapes", String(body.shape_count)],
      ["position", isThere ? [...state.poses.slice(7 * at, 7 * at + 3)].map((x) => x.toFixed(3)).join(", ") + " m" : "not there"],
      ["speed", isThere ? `${number(state.speeds[at], 3)} m/s` : "–"],
      ...(this.live?.chosenRows(state, at) ?? []),
    ]);
    const { series } = this.model;
    if (this.live) this.live.drawChosen(this.chosenPlot, share);
    else this.chosenPlot.draw(series.times, [{ values: this.speeds, color: "#f0a45a" }], share);
  }
}

function start(model, states) {
  if (!document.createElement("canvas").getContext("webgl2")) {
    fail("This browser cannot draw the page: it has no WebGL 2, or it is turned off.");
    return;
  }
  try {
    window.screePage = new Page(model, states);  // for scripts that drive the page
  } catch (error) {
    fail(`The page cannot be drawn: ${error.message}`);
    return;
  }
  document.body.dataset.state = "ready";
}

async function beginClip() {
  let clip;
  try {
    clip = await Clip.fromPage(document);
  } catch (error) {
    fail(`The animation in this page is damaged: ${error.message}`);
    return;
  }
  const last = clip.samples - 1;
  start(clip, [0, last >> 2, last >> 1, last].map((sample) => clip.state(clip.timeOf(sample))));
}

// Begins when the server has told of its tracks and the first state is there.
function beginLive() {
  document.body.dataset.live = "";
  const wait = () => {
    if (window.screePage || document.body.dataset.state === "error") return;
    live.want(0);
    const state = live.state(0);
    if (state) start(live, [state]);
    else requestAnimationFrame(wait);
  };
  const live = new Live(`ws://${window.location.host}/socket`, (kind, message) => {
    if (kind === "hello") wait();
    else if (kind === "replaced") window.location.reload();
    else if (window.screePage) window.screePage.live.hear(kind, message);
    else if (kind === "lost") element("message").textContent = "The server does not answer. Trying again.";
    else if (kind === "error") fail(message.text);
    return undefined;
  });
}

if (document.body.dataset.state !== "error") {  // the browser is not too old
  if (document.getElementById("clip")) beginClip();
  else beginLive();
}
