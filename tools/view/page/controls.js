// What the page can do while a server plays: tracks and branches, touch, comparison, what is drawn over the bodies.
import { decadeColor, kDiffers, paletteColor } from "scree/colors";
import { Comparison, kLeast } from "scree/compare";
import { kWords } from "scree/live";
import { element, number } from "scree/text";
import { Touch } from "scree/touch";
import { TrackList } from "scree/tracks";

const kTicks = { sleep: "#6f9fe0", wake: "#e8be54", hit: "#e9edf1", break: "#ff7b5c", restore: "#ff50c8" };
const kPhaseColors = ["#f0a45a", "#7fb2e5", "#8fd08a", "#e8be54", "#c49bea", "#e77f7f", "#7fd6d0", "#d8d8d8", "#cfa676", "#f29ac0", "#9fb36b"];
const kUnknown = [150, 150, 150];
const kMostBehind = 32;  // steps: the server takes a touch so far behind for one of the end while it runs

export class LiveControls {
  constructor(page, model) {
    this.page = page;
    this.model = model;
    this.comparison = new Comparison(model);
    model.hearFrame = (frame) => this.remember(frame);
    this.isSettling = false;
    this.touch = new Touch(page, model);
    this.list = new TrackList(page, model);
    page.trackHere = () => model.owner(model.track, page.stepNumber);
    page.goToStep = (step) => page.goToSample(step - model.first);
    page.touch = this.touch;
    page.say = (text) => this.say(text);
    page.scene.shade = (state, i, body) => this.shade(state, i, body);
    element("title").textContent = document.title = model.title;
    element("solver").replaceChildren(...model.solvers.map((name) => new Option(name.replaceAll("_", " "), name)));
    this.edited = new Set();  // fields of settings that the user has changed and not sent
    this.fillSettings();
    this.listen();
    this.list.show();
    this.keys = {
      ",": () => this.list.jump(-1),
      ".": () => this.list.jump(1),
      b: () => this.list.branch(),
      g: () => this.touch.shoot(0, 0),
      Delete: () => this.touch.deleteChosen(),
      Backspace: () => this.touch.deleteChosen(),  // what keyboards of Macs have
    };
  }

  // With those of the track that is shown.
  fillSettings() {
    const { gravity, substeps, solver } = this.model.tracks[this.model.track].settings;
    const values = { gravity: gravity.map((x) => Number(x.toPrecision(6))).join(", "), friction: "", substeps, solver };
    for (const [name, value] of Object.entries(values)) if (!this.edited.has(name)) element(name).value = value;
  }

  listen() {
    element("tools").addEventListener("change", (event) => { this.touch.tool = event.target.value; });
    element("marks").addEventListener("change", () => this.updateWants());
    element("run").addEventListener("click", () => this.run());
    for (const name of ["gravity", "friction", "substeps", "solver"]) {
      element(name).addEventListener("input", () => this.edited.add(name));
    }
    element("side-by-side").addEventListener("change", (event) => {
      const { orbit, scene } = this.page;
      orbit.lookAt(orbit.target.clone().add(scene.setSideBySide(event.target.checked)));
      orbit.zoom(event.target.checked ? 1.3 : 1 / 1.3);
    });
    element("apply").addEventListener("click", () => this.apply());
    element("to-parting").addEventListener("click", () => {
      const { parting } = this.comparison;
      if (parting?.step === undefined || parting.step === null) return;
      this.page.goToStep(parting.step);
      const body = this.model.bodies.findIndex(({ index, type }) => index === parting.body && type !== "fixed");
      if (body >= 0) this.page.choose(body);
    });
    element("map").addEventListener("click", (event) => {
      const box = element("map").getBoundingClientRect();
      const { first, last } = this.model;
      this.page.goToSample(Math.floor(((event.clientX - box.left) / box.width) * (last - first + 1)));
    });
  }

  hear(kind, message) {
    if (kind === "tracks") {
      this.list.show();
      this.fillSettings();
    } else if (kind === "branched") this.list.enter(message.track);
    else if (kind === "changed") this.change(message);
    else if (kind === "parted") this.showParting(message);
    else if (kind === "error") this.refuse(message.text);
    else if (kind === "lost") this.lose();
    else if (kind === "found") this.found();
  }

  refuse(text) {
    this.list.afterBranch = undefined;
    setTimeout(() => this.comparison.forgetAsked(), 1000);  // it may have been that
    this.say(text);
  }

  // Back after a lost connection, to the same worlds.
  found() {
    this.isLost = false;
    element("notice").hidden = true;
    this.comparison.clear();  // others may have changed the worlds meanwhile
    this.history = undefined;
    this.page.scene.standingKey = this.page.scene.secondKey = undefined;
    this.page.drawn = undefined;
  }

  lose() {
    this.isLost = false;
    this.say("The server does not answer: it has ended, or the connection is lost. Trying again.", true);
    this.isLost = true;
  }

  change({ step }) {
    this.comparison.drop(step);
    this.page.drawn = undefined;
  }

  // The server runs on to a step whether or not a page looks; to no step beyond the last one ends that.
  run() {
    const field = element("run-to");
    const to = Number(field.value);
    if (field.value === "" || !Number.isInteger(to) || to < 0) {
      this.say("Write the number of the step to run to; 0 ends a run.");
      return;
    }
    this.ask({ ask: "run", track: this.model.track, to });
  }

  // What the user wants of the server.
  ask(message) {
    if (!this.model.ask(message)) this.say("The server does not answer: nothing was changed.");
  }

  say(text, stays = false) {
    if (this.isLost) return;  // that stays until the server is back
    element("notice").textContent = text;
    element("notice").hidden = false;
    clearTimeout(this.silence);
    if (!stays) this.silence = setTimeout(() => { element("notice").hidden = true; }, 8000);
  }

  // Whether playing may go on behind the last step.
  get goesOn() {
    const { live, error } = this.model.tracks[this.model.track];
    return live && !error;
  }

  // A live track grows as it is played.
  extend(time) {
    if (!this.goesOn) return;
    const about = this.model.tracks[this.model.track];
    if (time >= this.model.duration) about.planned = Math.max(about.planned, about.last) + 1;
  }

  // A step on from the end of a live track.
  stepOn(sample) {
    if (!this.goesOn || sample + 1 < this.model.samples) return false;
    this.model.tracks[this.model.track].planned = this.model.first + sample + 1;
    this.page.goToSample(sample + 1);
    return true;
  }

  // Pauses where the live world is, not the few steps behind it that are still on their way; until the user goes
  // elsewhere.
  settle() {
    this.page.goToStep(this.page.stepNumber);
    this.isSettling = this.goesOn && this.model.last - this.page.stepNumber <= kMostBehind;
    this.settlesTo = this.page.stepNumber + kMostBehind;
  }

  keepToEnd() {
    if (!this.isSettling || this.page.isPlaying) return;
    const goal = Math.min(this.model.last, this.settlesTo);
    if (this.page.stepNumber === goal) return;
    this.page.goToStep(goal);
    this.isSettling = true;
  }

  setColors(by) {
    this.model.setShade(by);
    this.model.asked = "";
  }

  choose() {
    this.updateWants();
  }

  updateWants() {
    const { shown } = this.page.scene.marks;
    this.model.wantsDetails = shown.has("contacts") || shown.has("joints") || this.page.scene.chosen >= 0;
    this.model.asked = "";
  }

  // Before each picture.
  update() {
    this.keepToEnd();
    this.model.want(this.page.time, this.page.pace);
    if (this.comparison.check()) {
      this.page.drawn = undefined;
      element("parting").textContent = "";
      element("to-parting").hidden = true;
    }
    element("comparison").hidden = !this.comparison.isOn;
    if (this.comparison.isOn) this.comparison.drawMap(element("map"));
    this.list.showEvents();
  }

  get seen() {
    return [this.model.track, this.model.second, this.comparison.version, element("graphed").value].join();
  }

  secondState() {
    if (!this.comparison.isOn) return undefined;
    return this.model.stateIn(this.model.second, Math.min(this.page.time, this.model.timeOf(this.model.tracks[this.model.second].last - this.model.first)));
  }

  shade(state, i, body) {
    // Frames that came before the color was chosen tell of something else.
    const value = state.frame?.shade === this.model.shade ? state.values[i] : undefined;
    const { colorBy } = this.page.scene;
    if (value === undefined && colorBy !== "distance") return kUnknown;
    switch (colorBy) {
      case "island":
        return paletteColor(value);
      case "color":
        return value < 0 ? kUnknown : paletteColor(value);
      case "residual":
        return decadeColor(value, 1e-6, 1);
      case "force":
        return decadeColor(value, 1, 1e6);
      case "distance": {
        const { parting } = this.comparison;
        if (this.comparison.isOn && parting?.step === state.frame?.step && parting.body === body.index) return kDiffers;
        return this.comparison.shade(state, i);
      }
      default:
        return paletteColor(body.index);
    }
  }

  showParting(message) {
    if (message.a !== this.model.track || message.b !== this.model.second) return;
    this.comparison.takeParting(message);
    element("parting").textContent = message.step === null ? "The two have the same bits as far as both go."
      : `They part at step ${message.step}${message.text ? `: ${message.text}` : ""}.`;
    element("to-parting").hidden = message.step === null;
    this.page.drawn = undefined;
  }

  worldRows(figures) {
    const rows = [["residual", `${number(figures.residual)} m/s`], ["step", `${number(figures.milliseconds, 3)} ms`]];
    if (this.comparison.isOn) {
      const apart = this.comparison.at(this.page.stepNumber);
      rows.push(["largest distance", apart ? `${number(apart.largest)} m` : "–"]);
    }
    return rows;
  }

  // What only the server knows of the chosen body.
  chosenRows(state, at) {
    const body = this.model.bodies[this.page.scene.chosen];
    const rows = [["mass", body.mass > 0 ? `${number(body.mass)} kg` : "–"],
      ["awake", at >= 0 ? (state.awake[at] ? "yes" : "no") : "–"]];
    const items = [];
    const { frame } = state;
    if (frame?.hasDetails && at >= 0) {
      let force = 0;
      for (let i = 0; i < frame.contacts.length; i += kWords) {
        const [a, b] = [frame.contactBodies[i], frame.contactBodies[i + 1]];
        if (a !== body.index && b !== body.index) continue;
        force += frame.contacts[i + 8];
        const item = document.createElement("li");
        item.textContent = `touches body ${a === body.index ? b : a} with ${number(frame.contacts[i + 8], 3)} N, color ${frame.contacts[i + 9]}`;
        items.push(item);
      }
      rows.push(["contact points", String(items.length)], ["contact force", `${number(force, 3)} N`]);
      items.push(...this.jointItems(frame, body.index));
    }
    element("chosen-contacts").replaceChildren(...items);
    return rows;
  }

  // What a frame tells of the chosen body, for its plot.
  remember(frame) {
    const { history, model } = this;
    if (!history || model.owner(model.track, frame.step) !== frame.track) return;
    const at = frame.numbers[history.at] === history.body ? history.at : frame.numbers.indexOf(history.body);
    if (at < 0) return;
    history.at = at;
    const sample = frame.step - model.first;
    history.speeds[sample] = frame.speeds[at];
    if (frame.energies) history.energies[sample] = frame.energies[at];
    history.version += 1;
  }

  // The joints of a body, in words.
  jointItems({ joints, jointNumbers }, index) {
    const items = [];
    for (let i = 0; i < joints.length; i += kWords) {
      const [a, b, joint, kind] = jointNumbers.subarray(i + 8, i + kWords);
      if (a !== index && b !== index) continue;
      const other = a === index ? b : a;
      const item = document.createElement("li");
      item.textContent = `joint ${joint}, ${this.model.kindsOfJoints[kind].replaceAll("_", " ")}, with ` +
        `${other === 0xffffffff ? "the world" : `body ${other}`}: ${number(joints[i + 6], 3)} N, ${number(joints[i + 7], 3)} N m`;
      items.push(item);
    }
    return items;
  }

  // Speed and energy of the chosen body where its frames have been here.
  drawChosen(plot, share) {
    const { model } = this;
    const body = this.page.scene.chosen;
    if (this.history?.body !== body || this.history.track !== model.track) {
      this.history = { body, track: model.track, at: 0, version: 0, speeds: [], energies: [] };
      for (const frame of model.frames.values()) this.remember(frame);
    }
    const { speeds, energies, version } = this.history;
    plot.draw(model.series.times, [{ values: energies, color: "#7fb2e5" }, { values: speeds, color: "#f0a45a" }], share,
      { duration: model.duration, version });
  }

  drawTimeline(graph, share) {
    const { series } = this.model;
    const kind = element("graphed").value;
    const legend = element("legend");
    const duration = this.model.duration;
    let lines;
    if (kind === "milliseconds") {
      lines = series.phases.map((values, i) => ({ values, color: kPhaseColors[i] }));
      legend.replaceChildren(...this.model.phases.map((name, i) => {
        const each = document.createElement("span");
        each.textContent = `${name.replaceAll("_", " ")} `;
        each.style.color = kPhaseColors[i];
        return each;
      }));
    } else if (kind === "distance") {
      lines = [{ values: this.comparison.series, color: "#ff7b5c" }];
      legend.textContent = `decades of the largest distance above ${kLeast} m`;
    } else {
      lines = [{ values: series.contacts, color: "#7fb2e5" }, { values: series.energy, color: "#f0a45a" }];
      legend.innerHTML = '<span class="contacts">contacts</span> <span class="energy">kinetic energy</span>';
    }
    graph.draw(series.times, lines, share, { duration, isShared: kind === "milliseconds", version: `${kind} ${series.version} ${this.comparison.version}` });
    this.drawTicks(duration);
  }

  drawTicks(duration) {
    const canvas = element("ticks");
    const events = this.list.events;
    const { keyframes } = this.model.tracks[this.model.track];
    const state = `${this.model.track} ${events.length} ${keyframes.length} ${duration} ${canvas.clientWidth}`;
    if (this.ticked === state) return;
    this.ticked = state;
    canvas.width = canvas.clientWidth;
    canvas.height = 10;
    const context = canvas.getContext("2d");
    const mark = (step, color, from, to) => {
      context.fillStyle = color;
      context.fillRect((canvas.width * this.model.timeOf(step - this.model.first)) / (duration || 1), from, 1, to - from);
    };
    for (const step of keyframes) mark(step, "#8a949e", 0, 3);
    for (const { step, kind } of events) mark(step, kTicks[kind], kind === "hit" ? 6 : 3, 10);
  }

  apply() {
    const what = { kind: "settings" };
    for (const name of this.edited) {
      const { value } = element(name);
      if (value === "") continue;
      what[name] = name === "solver" ? value : Number(value);
      if (name !== "gravity") continue;
      const parts = value.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
      if (parts.length !== 3 || !parts.every(Number.isFinite)) {
        this.say(`Gravity takes three numbers, such as 0, -9.81, 0; "${value}" are not.`);
        return;
      }
      what.gravity = parts;
    }
    if (Object.keys(what).length === 1) {
      this.say("Write another gravity, friction, number of substeps or solver first.");
      return;
    }
    this.edited.clear();
    this.touch.send(what);
  }
}
