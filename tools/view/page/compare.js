// Two tracks beside each other: how far their bodies are apart, step by step, as a line and as a map over all bodies.
import { decadeColor } from "scree/colors";

const kMostRows = 64;  // of the map: bodies by index
const kMostAsked = 16;
export const kLeast = 1e-7;  // m: half of a unit in the last place at 1 m
const kMost = 1;

export class Comparison {
  constructor(model) {
    this.model = model;
    this.version = 0;
    this.clear();
    model.alsoWanted = () => this.missing();
    model.isAwaited = (step) => this.isOn && step > this.doneTo && step <= this.doneTo + kMostAsked && !this.steps.has(step);
  }

  clear() {
    this.steps = new Map();  // by step: the largest distance, the body, and a column of the map
    this.pair = undefined;
    this.doneTo = this.firstOfBoth - 1;  // all steps up to it are compared
    this.parting = undefined;
    this.forgetAsked();
    this.version += 1;
  }

  // What was asked for may have been lost.
  forgetAsked() {
    this.askedTo = undefined;
    this.isAsked = false;
  }

  // What was compared of a step does not hold any more.
  drop(step) {
    if (!this.steps.delete(step)) return;
    this.doneTo = Math.min(this.doneTo, step - 1);
    this.version += 1;
  }

  get firstOfBoth() {
    const { model } = this;
    if (!this.isOn) return 0;
    return Math.max(model.first, model.tracks[model.root(model.second)].first);
  }

  get isOn() {
    return this.model.second >= 0 && this.model.second !== this.model.track;
  }

  // Begins anew when other tracks are compared.
  check() {
    const pair = this.isOn ? `${this.model.track} ${this.model.second}` : undefined;
    if (this.pair !== pair) {
      this.clear();
      this.pair = pair;
      this.askForParting();
      return true;
    }
    this.askForParting();
    return false;
  }

  // Again when there are more steps, as long as the two have not parted.
  askForParting() {
    if (!this.isOn || this.isAsked || (this.parting && this.parting.step !== null)) return;
    const common = Math.min(this.model.last, this.model.tracks[this.model.second].last);
    if (this.askedTo === common) return;
    this.askedTo = common;
    this.isAsked = true;
    this.model.ask({ ask: "parted", a: this.model.track, b: this.model.second });
  }

  takeParting(message) {
    this.parting = message;
    // Of tracks that go on, later.
    setTimeout(() => { this.isAsked = false; }, 1000);
  }

  // Steps that both have, and that have not been compared; a few.
  missing() {
    if (!this.isOn) return [];
    const { model } = this;
    const last = Math.min(model.last, model.tracks[model.second].last);
    const frames = [];
    while (this.doneTo < last && this.steps.has(this.doneTo + 1)) this.doneTo += 1;
    const most = Math.min(kMostAsked, model.mostAtOnce);
    for (let step = this.doneTo + 1; step <= last && frames.length < most; ++step) {
      if (this.steps.has(step)) continue;
      let isShared = true;
      for (const track of [model.track, model.second]) {
        if (model.frameOf(track, step)) continue;
        frames.push([model.owner(track, step), step]);
        isShared = false;
      }
      if (isShared) this.compare(step);
    }
    return frames;
  }

  // Of all bodies of the first frame: the distance to the one of the same index in the second, in m.
  distances(a, b) {
    if (a === b) return new Float32Array(a.numbers.length);
    const { bodies } = this.model;
    const isSame = a.numbers.length === b.numbers.length && a.numbers.every((number, i) => number === b.numbers[i]);
    const places = isSame ? undefined : new Map([...b.numbers].map((number, i) => [bodies[number].index, i]));
    return Float32Array.from(a.numbers, (number, i) => {
      const place = places ? places.get(bodies[number].index) : i;
      if (place === undefined) return kMost;
      const [p, q] = [3 * i, 3 * place];
      return Math.hypot(a.positions[p] - b.positions[q], a.positions[p + 1] - b.positions[q + 1],
        a.positions[p + 2] - b.positions[q + 2]);
    });
  }

  compare(step) {
    const [a, b] = [this.model.frameOf(this.model.track, step), this.model.frameOf(this.model.second, step)];
    if (!a || !b) return;
    const distances = this.distances(a, b);
    const rows = new Float32Array(Math.max(1, Math.min(kMostRows, distances.length)));
    let largest = 0;
    let body = -1;
    distances.forEach((distance, i) => {
      const row = Math.floor((rows.length * i) / distances.length);
      rows[row] = Math.max(rows[row], distance);
      if (distance > largest) [largest, body] = [distance, a.numbers[i]];
    });
    this.steps.set(step, { largest, body, rows });
    this.version += 1;
  }

  at(step) {
    if (!this.steps.has(step)) this.compare(step);
    return this.steps.get(step);
  }

  // Decades above the least distance, over the samples.
  get series() {
    if (this.seriesVersion !== this.version) {
      this.seriesVersion = this.version;
      this.kept = [];
      for (let step = this.model.first; step <= this.model.last; ++step) {
        const known = this.steps.get(step);
        this.kept.push(known ? Math.max(0, Math.log10(known.largest / kLeast)) : null);
      }
    }
    return this.kept;
  }

  // The color of the i-th body of a state.
  shade(state, i) {
    const a = state.frame;
    const b = this.isOn && a ? this.model.frameOf(this.model.second, a.step) : undefined;
    if (this.shaded?.a !== a || this.shaded.b !== b) this.shaded = { a, b, distances: b ? this.distances(a, b) : undefined };
    const { distances } = this.shaded;
    return decadeColor(distances ? distances[i] : 0, kLeast, kMost);
  }

  // Steps to the right, bodies down.
  drawMap(canvas) {
    const state = `${this.pair} ${this.version}`;
    if (this.drawn === state) return;
    this.drawn = state;
    const { first, last } = this.model;
    const columns = Math.max(1, Math.min(1024, last - first + 1));
    const rows = Math.max(1, ...[...this.steps.values()].slice(0, 1).map((each) => each.rows.length));
    canvas.width = columns;
    canvas.height = rows;
    const context = canvas.getContext("2d");
    const image = context.createImageData(columns, rows);
    for (let column = 0; column < columns; ++column) {
      const known = this.steps.get(first + Math.floor((column * (last - first + 1)) / columns));
      for (let row = 0; row < rows; ++row) {
        const color = known ? decadeColor(known.rows[Math.floor((row * known.rows.length) / rows)], kLeast, kMost) : [60, 66, 72];
        image.data.set([...color, 255], 4 * (columns * row + column));
      }
    }
    context.putImageData(image, 0, 0);
  }
}
