// The animation that a page carries: a header in JSON and numbers, packed by gzip and written in base 64. See
// ../clip.h for what is in it.
import { kPoseLength } from "scree/layer";

async function unpack(text) {
  const letters = atob(text);
  const packed = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) packed[i] = letters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

// A body's poses, one behind the other. The numbers are differences, the lowest bytes of a component before the
// others.
function readTrack(bytes, track, count) {
  const poses = new Float32Array(kPoseLength * count);
  let plane = track.offset;
  for (let part = 0; part < kPoseLength; ++part) {
    const length = part < 3 ? track.bytes : 2;
    const end = 256 ** length;
    const scale = part < 3 ? (track.upper[part] - track.lower[part]) / (end - 1) : 1 / 32767;
    let code = 0;
    for (let i = 0; i < count; ++i) {
      for (let k = 0, weight = 1; k < length; ++k, weight *= 256) code += weight * bytes[plane + k * count + i];
      code %= end;
      const turned = code < end / 2 ? code : code - end;
      poses[kPoseLength * i + part] = part < 3 ? track.lower[part] + scale * code : scale * turned;
    }
    plane += length * count;
  }
  return poses;
}

export class Clip {
  constructor(buffer) {
    const bytes = new Uint8Array(buffer);
    const headLength = new DataView(buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + headLength)));
    const numbers = bytes.slice(4 + headLength);
    this.title = head.title;
    this.size = head.size;
    this.up = head.up;
    this.times = head.times;
    this.steps = head.steps;
    this.stats = head.stats;
    this.meshes = head.meshes.map((mesh) => ({
      positions: new Float32Array(numbers.buffer, mesh.positions, 3 * mesh.vertices),
      normals: new Float32Array(numbers.buffer, mesh.normals, 3 * mesh.vertices),
      indices: new Uint32Array(numbers.buffer, mesh.indices, mesh.corners),
      isSurface: mesh.surface,
    }));
    this.bodies = head.bodies.map((body) => ({
      ...body,
      pieceCount: body.shapes.length,
      poses: body.track ? readTrack(numbers, body.track, body.count) : Float32Array.from(body.pose),
    }));
    this.isStanding = (body) => body.type === "fixed" && !body.track;
    this.isLive = false;
    this.version = 0;  // the series stay as they are
    this.series = { times: this.times, ...this.stats };
  }

  static async fromPage(document) {
    return new Clip(await unpack(document.getElementById("clip").textContent.trim()));
  }

  get samples() {
    return this.times.length;
  }

  get duration() {
    return this.times[this.times.length - 1];
  }

  timeOf(sample) {
    return this.times[sample];
  }

  stepOf(sample) {
    return this.steps[sample];
  }

  // The farthest time on the way from one to a later one that can be shown at once.
  reachable(from, to) {
    return to;
  }

  figures(sample) {
    const { bodies, awake, contacts, energy } = this.stats;
    return { bodies: bodies[sample], awake: awake[sample], contacts: contacts[sample], energy: energy[sample] };
  }

  // Who is where at a time: `numbers` of bodies that move and `poses`, seven numbers each, `speeds` in m/s, and
  // the numbers of bodies that stand still, which are the same as long as `standingKey` is.
  state(time) {
    const [sample, share] = this.stateAt(time);
    const isThere = (body) => sample >= body.first && sample < body.first + body.count;
    const numbers = [];
    const standing = [];
    let standingKey = "";
    this.bodies.forEach((body, number) => {
      if (!isThere(body)) return;
      if (!this.isStanding(body)) return numbers.push(number);
      if (body.first > 0 || body.count < this.samples) standingKey += `${number} `;
      return standing.push(number);
    });
    const poses = new Float32Array(kPoseLength * numbers.length);
    numbers.forEach((number, i) => {
      this.poseAt(this.bodies[number], sample, share, poses.subarray(kPoseLength * i, kPoseLength * i + kPoseLength));
    });
    const speeds = numbers.map((number) => this.speedAt(this.bodies[number], sample));
    return { numbers, poses, speeds, awake: [], standing, standingKey };
  }

  // m/s over all samples; NaN where the body is not there.
  speedsOf(number) {
    const body = this.bodies[number];
    return this.times.map((_, sample) =>
      (sample >= body.first && sample < body.first + body.count ? this.speedAt(body, sample) : NaN));
  }

  // The last sample that is not after the time, and how far the time is on the way to the next one, 0 to 1.
  stateAt(time) {
    const sample = this.sampleAt(time);
    const next = Math.min(sample + 1, this.times.length - 1);
    const length = this.times[next] - this.times[sample];
    return [sample, length > 0 ? Math.min(1, (time - this.times[sample]) / length) : 0];
  }

  // The last sample that is not after the time.
  sampleAt(time) {
    let low = 0;
    let high = this.times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // Writes where a body is between a sample and the next one. False: it is not there.
  poseAt(body, sample, share, pose) {
    const at = sample - body.first;
    if (at < 0 || at >= body.count) return false;
    if (!body.track) {
      pose.set(body.poses);
      return true;
    }
    const a = kPoseLength * at;
    const b = at + 1 < body.count ? a + kPoseLength : a;
    let length = 0;
    for (let i = 0; i < kPoseLength; ++i) {
      pose[i] = body.poses[a + i] + share * (body.poses[b + i] - body.poses[a + i]);
      if (i >= 3) length += pose[i] * pose[i];
    }
    length = Math.sqrt(length) || 1;
    for (let i = 3; i < kPoseLength; ++i) pose[i] /= length;
    return true;
  }

  // m/s, of the body's origin, from a sample to the next one, or from the one before at the end.
  speedAt(body, sample) {
    const at = Math.min(sample - body.first, body.count - 2);
    if (!body.track || at < 0 || sample - body.first >= body.count) return 0;
    const a = kPoseLength * at;
    const p = body.poses;
    const way = Math.hypot(p[a + 7] - p[a], p[a + 8] - p[a + 1], p[a + 9] - p[a + 2]);
    return way / (this.times[body.first + at + 1] - this.times[body.first + at]);
  }
}
