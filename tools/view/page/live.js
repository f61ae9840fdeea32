// A world that is played elsewhere: what the server of `scree view` tells of its tracks, kept in parts. See
// ../frame.h and ../engine.h for what is sent.
//
// Samples are steps since the first one of the track's root. A branch shares its past with its parent: what is
// before its beginning is asked of that.
import { kPoseLength } from "scree/layer";

export const kWords = 12;  // of a contact and of a joint, see ../frame.h

const kMostBytes = 400 * 2 ** 20;
const kAhead = 30;    // steps
const kMostWaiting = 128 * 2 ** 20;  // bytes, asked for at once
const kAround = 12;   // steps, while it stands still
const kFigures = ["time", "bodies", "awake", "contacts", "energy", "residual", "milliseconds", "played"];
const kTypes = ["fixed", "kinematic", "dynamic"];
const kShades = { island: 1, color: 2, residual: 3, force: 4 };

class Frame {
  constructor(buffer) {
    const view = new DataView(buffer);
    const word = (i) => view.getUint32(4 * i, true);
    this.track = word(1);
    this.step = view.getFloat64(8, true);
    this.roster = word(4);
    const [n, contacts, joints] = [word(5), word(6), word(7)];
    this.shade = word(8);
    this.hasDetails = word(9) === 1;
    this.bytes = buffer.byteLength;
    let at = 40;
    const take = (Type, count) => {
      const array = new Type(buffer, at, count);
      at += array.byteLength;
      return array;
    };
    this.numbers = take(Uint32Array, n);
    this.positions = take(Float32Array, 3 * n);
    this.speeds = take(Float32Array, n);
    this.values = take(Float32Array, n);
    this.rotations = take(Int16Array, 4 * n);
    this.awake = take(Uint8Array, n);
    at = 4 * Math.ceil(at / 4);
    this.contactBodies = new Uint32Array(buffer, at, kWords * contacts);
    this.contacts = take(Float32Array, kWords * contacts);
    this.jointNumbers = new Uint32Array(buffer, at, kWords * joints);
    this.joints = take(Float32Array, kWords * joints);
    this.energies = this.hasDetails ? take(Float32Array, n) : undefined;
  }

  poses() {
    const n = this.numbers.length;
    const poses = new Float32Array(kPoseLength * n);
    const { positions: p, rotations: q } = this;
    const unit = 1 / 32767;
    for (let i = 0, at = 0; i < n; ++i, at += kPoseLength) {
      poses[at] = p[3 * i];
      poses[at + 1] = p[3 * i + 1];
      poses[at + 2] = p[3 * i + 2];
      poses[at + 3] = unit * q[4 * i];
      poses[at + 4] = unit * q[4 * i + 1];
      poses[at + 5] = unit * q[4 * i + 2];
      poses[at + 6] = unit * q[4 * i + 3];
    }
    return poses;
  }
}

// Bodies as a message brings them.
class Columns {
  constructor(numbers, { bodies, pieces, columns }) {
    let at = columns;
    const take = (Type, count) => {
      const array = new Type(numbers, at, count);
      at += array.byteLength;
      return array;
    };
    this.indices = take(Uint32Array, bodies);
    this.shapeCounts = take(Uint32Array, bodies);
    this.ends = take(Uint32Array, bodies);
    this.masses = take(Float32Array, bodies);
    this.poses = take(Float32Array, kPoseLength * bodies);
    this.centers = take(Float32Array, 3 * bodies);
    this.meshes = take(Uint32Array, pieces);
    this.piecePoses = take(Float32Array, kPoseLength * pieces);
    this.scales = take(Float32Array, 3 * pieces);
    this.types = take(Uint8Array, bodies);
    for (let row = 1; row < bodies; ++row) this.ends[row] += this.ends[row - 1];  // from counts
  }
}

// One of them. There may be a million: they take two words each.
class Body {
  constructor(columns, row) {
    this.columns = columns;
    this.row = row;
  }

  get index() {
    return this.columns.indices[this.row];
  }

  get type() {
    return kTypes[this.columns.types[this.row]];
  }

  get shape_count() {
    return this.columns.shapeCounts[this.row];
  }

  get mass() {
    return this.columns.masses[this.row];
  }

  get pose() {
    return this.columns.poses.subarray(kPoseLength * this.row, kPoseLength * (this.row + 1));
  }

  get center() {
    return this.columns.centers.subarray(3 * this.row, 3 * (this.row + 1));
  }

  get pieceCount() {
    return this.columns.ends[this.row] - this.firstPiece;
  }

  get firstPiece() {
    return this.row > 0 ? this.columns.ends[this.row - 1] : 0;
  }

  // As a page has them: the mesh, then the place in the body's frame and the scale.
  get shapes() {
    const { meshes, piecePoses, scales } = this.columns;
    return Array.from({ length: this.pieceCount }, (_, i) => {
      const piece = this.firstPiece + i;
      return [meshes[piece], ...piecePoses.subarray(kPoseLength * piece, kPoseLength * (piece + 1)),
        ...scales.subarray(3 * piece, 3 * (piece + 1))];
    });
  }
}

// Between two poses that begin at places of an array, into the first.
function blend(poses, at, others, from, share) {
  for (let k = 0; k < 3; ++k) poses[at + k] += share * (others[from + k] - poses[at + k]);
  const x = poses[at + 3], y = poses[at + 4], z = poses[at + 5], w = poses[at + 6];
  const dot = x * others[from + 3] + y * others[from + 4] + z * others[from + 5] + w * others[from + 6];
  const other = dot < 0 ? -share : share;
  const own = 1 - share;
  const qx = own * x + other * others[from + 3], qy = own * y + other * others[from + 4];
  const qz = own * z + other * others[from + 5], qw = own * w + other * others[from + 6];
  const scale = 1 / (Math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw) || 1);
  poses[at + 3] = scale * qx;
  poses[at + 4] = scale * qy;
  poses[at + 5] = scale * qz;
  poses[at + 6] = scale * qw;
}

function areSame(a, b) {
  if (a.length !== b.length) return false;
  for (let i = 0; i < a.length; ++i) if (a[i] !== b[i]) return false;
  return true;
}

// The poses of the first frame, moved towards those of the second.
function posesBetween(frame, next, share) {
  const poses = frame.poses();
  const others = next.poses();
  const { numbers } = frame;
  const places = areSame(numbers, next.numbers) ? undefined : new Map([...next.numbers].map((number, i) => [number, i]));
  for (let i = 0; i < numbers.length; ++i) {
    const place = places ? places.get(numbers[i]) : i;
    if (place !== undefined) blend(poses, kPoseLength * i, others, kPoseLength * place, share);
  }
  return poses;
}

export class Live {
  // `tell(kind, message)`: of hello, tracks, branched, changed, parted, error, lost and found.
  constructor(address, tell) {
    this.address = address;
    this.tell = tell;
    this.isLive = true;
    this.bodies = [];
    this.meshes = [];
    this.rosters = new Map();
    this.frames = new Map();  // by "track step"
    this.bytes = 0;
    this.tracks = [];
    this.rows = [];    // by track: figures by step since its first
    this.events = [];  // by track
    this.track = 0;
    this.second = -1;  // the track that is shown beside it
    this.shade = 0;
    this.wantsDetails = false;
    this.isPlaying = false;
    this.version = 0;      // of all that is shown
    this.pastVersion = 0;  // of figures and events
    this.asked = "";
    this.wanted = [0, 0];
    this.comesAgain = { bodies: 0, meshes: 0 };  // how many are known already
    this.connect();
  }

  connect() {
    this.socket = new WebSocket(this.address);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("message", ({ data }) => {
      if (typeof data === "string") this.hear(JSON.parse(data));
      else this.take(data);
    });
    this.socket.addEventListener("close", () => {
      this.asked = "";
      if (!this.isLost) this.tell("lost");
      this.isLost = true;
      setTimeout(() => this.connect(), 1000);
    });
  }

  hear(message) {
    if (message.kind === "hello") {
      if (this.session && this.session !== message.session) return this.tell("replaced");
      const isBack = this.session === message.session;
      Object.assign(this, { session: message.session, title: message.title, up: message.up, size: message.size,
        phases: message.phases, solvers: message.solvers, kindsOfJoints: message.joints, compares: message.compares });
      this.hear(message.tracks);
      if (!isBack && message.compares) this.second = 1;
      if (isBack) {  // all of it comes again
        this.comesAgain = { bodies: this.bodies.length, meshes: this.meshes.length };
        this.rows = [];
        this.events = [];
        this.kept = undefined;
        this.pastVersion += 1;
        this.asked = "";
        this.frames.clear();
        this.bytes = 0;
      }
      this.isLost = false;
      return this.tell(isBack ? "found" : "hello", message);
    }
    if (message.kind === "tracks") {
      this.tracks = message.tracks;
      this.version += 1;
    } else if (message.kind === "past") {
      this.learn(message);
      return undefined;
    } else if (message.kind === "changed") {
      this.forget(`${message.track} ${message.step}`);
      this.asked = "";
    }
    return this.tell(message.kind, message);
  }

  learn({ track, from, dt, rows, events, keyframes }) {
    const known = (this.rows[track] ??= []);
    const first = this.tracks[track].first;
    rows.forEach((row, i) => { known[from - first + i] = row; });
    (this.events[track] ??= []).push(...events.map(([step, kind, body, count, value]) => ({ step, kind, body, count, value })));
    const about = this.tracks[track];
    about.last = Math.max(about.last, from + rows.length - 1);
    Object.assign(about, { dt, keyframes });
    this.version += 1;
    this.pastVersion += 1;
  }

  take(buffer) {
    const kind = new DataView(buffer).getUint32(0, true);
    if (kind === 1) this.takeNews(buffer);
    else if (kind === 2) this.rosters.set(new DataView(buffer).getUint32(4, true), new Uint32Array(buffer, 12));
    else this.takeFrame(new Frame(buffer));
  }

  takeNews(buffer) {
    const length = new DataView(buffer).getUint32(4, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
    const numbers = buffer.slice(8 + length);
    const again = this.comesAgain;
    for (const mesh of head.meshes.slice(again.meshes)) {
      this.meshes.push({
        positions: new Float32Array(numbers, mesh.positions, 3 * mesh.vertices),
        normals: new Float32Array(numbers, mesh.normals, 3 * mesh.vertices),
        indices: new Uint32Array(numbers, mesh.indices, mesh.corners),
        isSurface: mesh.surface,
      });
    }
    const columns = new Columns(numbers, head);
    for (let row = again.bodies; row < head.bodies; ++row) this.bodies.push(new Body(columns, row));
    again.meshes = Math.max(0, again.meshes - head.meshes.length);
    again.bodies = Math.max(0, again.bodies - head.bodies);
  }

  takeFrame(frame) {
    const key = `${frame.track} ${frame.step}`;
    this.forget(key);
    this.frames.set(key, frame);
    this.bytes += frame.bytes;
    this.frameBytes = frame.bytes;
    while (this.bytes > kMostBytes) this.forgetFarthest();
    const about = this.tracks[frame.track];
    if (about && frame.step > about.last) about.last = frame.step;
    this.version += 1;
    this.hearFrame?.(frame);
  }

  forget(key) {
    const frame = this.frames.get(key);
    if (!frame) return;
    this.bytes -= frame.bytes;
    this.frames.delete(key);
  }

  // A tenth of the frames: those far from where the page looks, that nobody waits for.
  forgetFarthest() {
    const here = this.stepOf(this.wanted[0]);
    let list = [...this.frames.values()].filter(({ step }) => !this.isAwaited?.(step));
    if (list.length === 0) list = [...this.frames.values()];
    list.sort((a, b) => Math.abs(b.step - here) - Math.abs(a.step - here));
    for (const { track, step } of list.slice(0, Math.ceil(list.length / 10))) this.forget(`${track} ${step}`);
  }

  // How many frames may be asked for at once.
  get mostAtOnce() {
    return Math.max(2, Math.floor(kMostWaiting / (this.frameBytes || 1)));
  }

  // False: it cannot be asked for now.
  ask(message) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  // Which track has a step, the track itself or what it branched off.
  owner(track, step) {
    while (this.tracks[track].parent !== null && step < this.tracks[track].first) track = this.tracks[track].parent;
    return track;
  }

  root(track) {
    while (this.tracks[track].parent !== null) track = this.tracks[track].parent;
    return track;
  }

  get first() {
    return this.tracks[this.root(this.track)].first;
  }

  get last() {
    return this.tracks[this.track].last;
  }

  // The last step that can be gone to: a live track runs on to what its scene has planned.
  get end() {
    const { last, planned, live, error } = this.tracks[this.track];
    return live && !error ? Math.max(last, planned) : last;
  }

  get samples() {
    return this.end - this.first + 1;
  }

  stepOf(sample) {
    return this.first + sample;
  }

  // s; nominal where the step has not been played yet.
  timeOf(sample) {
    return this.timeIn(this.track, this.first + sample);
  }

  timeIn(track, step) {
    const about = this.tracks[track];
    if (about.parent !== null && step < about.first) return this.timeIn(about.parent, step);
    const before = about.parent !== null ? this.timeIn(about.parent, about.first) : 0;
    const rows = this.rows[track] ?? [];
    const row = rows[step - about.first];
    if (row) return before + row[0];
    const known = rows.length > 0 ? rows.length - 1 : 0;
    return before + (rows[known]?.[0] ?? 0) + (step - about.first - known) * (about.dt || 1 / 60);
  }

  get duration() {
    return this.timeOf(this.samples - 1);
  }

  sampleAt(time) {
    let low = 0;
    let high = this.samples - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.timeOf(middle) <= time + 1e-9) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  figures(sample) {
    const step = this.first + sample;
    const track = this.owner(this.track, step);
    const row = this.rows[track]?.[step - this.tracks[track].first];
    if (!row) return undefined;
    const figures = Object.fromEntries(kFigures.map((name, i) => [name, row[i]]));
    if (!figures.played) figures.awake = figures.contacts = figures.energy = figures.residual = null;
    figures.phases = row.slice(kFigures.length);
    return figures;
  }

  // Lists over the samples whose figures are known; they grow, and `version` with them.
  get series() {
    if (this.kept?.track !== this.track) {
      this.kept = { track: this.track, version: 0, times: [], contacts: [], energy: [], milliseconds: [], residual: [],
        phases: this.phases.map(() => []) };
    }
    const list = this.kept;
    for (let figures; list.times.length < this.samples && (figures = this.figures(list.times.length)); list.version += 1) {
      list.times.push(this.timeOf(list.times.length));
      for (const name of ["contacts", "energy", "milliseconds", "residual"]) list[name].push(figures[name]);
      list.phases.forEach((each, i) => each.push(figures.played ? figures.phases[i] : null));
    }
    return list;
  }

  // What happened in the track and before it, by step.
  get happened() {
    const key = `${this.track} ${this.pastVersion}`;
    if (this.happenedKey !== key) {
      this.happenedKey = key;
      const lists = [];
      for (let track = this.track, end = Infinity; track !== null; track = this.tracks[track].parent) {
        const until = end;
        lists.push((this.events[track] ?? []).filter(({ step }) => step <= until));
        end = this.tracks[track].first;
      }
      this.happenedList = lists.reverse().flat();
    }
    return this.happenedList;
  }

  frameOf(track, step) {
    return this.frames.get(`${this.owner(track, step)} ${step}`);
  }

  isFresh(frame) {
    return frame && (this.shade === 0 || frame.shade === this.shade) && (!this.wantsDetails || frame.hasDetails);
  }

  reachable(from, to) {
    let sample = this.sampleAt(from);
    const goal = this.sampleAt(to) + 1;
    while (sample < goal && sample + 1 < this.samples && this.frameOf(this.track, this.first + sample + 1)) sample += 1;
    return Math.max(from, Math.min(to, this.timeOf(sample)));
  }

  setShade(name) {
    this.shade = kShades[name] ?? 0;
  }

  // Asks for the frames that are needed soon, the nearest first. `pace`: s of the world's time to the next picture;
  // the end of a live track runs ahead that far.
  want(time, pace = 0) {
    const sample = this.sampleAt(time);
    this.wanted = [sample, time];
    const step = this.first + sample;
    const steps = [step];
    const { live, last } = this.tracks[this.track];
    const ahead = Math.min(kAhead, this.mostAtOnce);
    const limit = live ? last : Math.min(last, this.end);
    if (time > this.timeOf(sample) || this.isPlaying) steps.push(step + 1);
    if (this.isPlaying) {
      const beyond = live ? Math.ceil(pace / (this.tracks[this.track].dt || 1 / 60)) + 1 : 0;
      for (let i = 2; i <= ahead && step + i <= Math.max(limit, step + beyond); ++i) steps.push(step + i);
    } else {
      for (let i = 1; i <= Math.min(kAround, ahead); ++i) {
        if (step + i <= limit) steps.push(step + i);
        if (step - i >= this.first) steps.push(step - i);
      }
    }
    const frames = [];
    const keys = new Set();
    for (const track of this.second >= 0 ? [this.track, this.second] : [this.track]) {
      const about = this.tracks[track];
      for (const wanted of steps) {
        // The end of the second one stays, where the first one goes on.
        const each = track === this.track || about.live ? wanted : Math.min(wanted, about.last);
        if (each > about.last && (!about.live || (!this.isPlaying && each > step))) continue;
        if (each < this.tracks[this.root(track)].first) continue;
        const owner = this.owner(track, each);
        const key = `${owner} ${each}`;
        if (keys.has(key) || this.isFresh(this.frames.get(key))) continue;
        keys.add(key);
        frames.push([owner, each]);
      }
    }
    if (this.alsoWanted && frames.length < 8) frames.push(...this.alsoWanted());
    if (frames.length === 0) return;
    frames.sort((a, b) => Math.abs(a[1] - step) - Math.abs(b[1] - step));
    const message = { ask: "frames", frames, shade: this.shade, details: this.wantsDetails };
    const text = JSON.stringify(message);
    if (text === this.asked) return;
    if (this.ask(message)) this.asked = text;
  }

  // As Clip.state. While the frame is on its way: the last state, or nothing if there is none.
  state(time) {
    const state = this.stateIn(this.track, time);
    this.isWaiting = !state;
    if (state) this.lastState = state;
    return state ?? this.lastState;
  }

  stateIn(track, time) {
    const sample = this.sampleAt(time);
    const step = this.first + sample;
    if (step > this.tracks[track].last) return undefined;
    const frame = this.frameOf(track, step);
    if (!frame) return undefined;
    const start = this.timeOf(sample);
    const next = time > start && sample + 1 < this.samples ? this.frameOf(track, step + 1) : undefined;
    const poses = next ? posesBetween(frame, next, Math.min(1, (time - start) / (this.timeOf(sample + 1) - start || 1)))
      : frame.poses();
    return { numbers: frame.numbers, poses, speeds: frame.speeds, values: frame.values, awake: frame.awake,
      standing: this.rosters.get(frame.roster) ?? [], standingKey: String(frame.roster), frame };
  }
}
