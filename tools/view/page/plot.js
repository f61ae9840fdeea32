// Lines over time on a small canvas.

// Keeps the lines, which are the same as long as the series are, and draws where the time stands anew.
export class Plot {
  constructor(canvas) {
    this.canvas = canvas;
    this.lines = document.createElement("canvas");
    this.drawn = undefined;
  }

  // `series`: {values, color} each, drawn from 0, or its least value below, to its largest; values that are no numbers are left
  // out. `times`: s, ascending, of all values. `at`: where the time stands, from 0 to 1. `duration`: s, of the
  // whole width. `isShared`: all have the scale of the largest. `version`: another one when values have been added.
  draw(times, series, at, { duration = times[times.length - 1], isShared = false, version = 0 } = {}) {
    const ratio = window.devicePixelRatio || 1;
    const width = this.canvas.clientWidth;
    const height = this.canvas.clientHeight;
    if (!width) return;
    const state = [width, height, ratio, duration, version, ...series.map(({ values }) => values)];
    if (!this.drawn || this.drawn.some((each, i) => each !== state[i])) {
      this.drawn = state;
      for (const canvas of [this.canvas, this.lines]) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
      }
      this.drawLines(times, series, width, height, ratio, duration || 1, isShared);
    }
    const context = this.canvas.getContext("2d");
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    context.drawImage(this.lines, 0, 0);
    context.fillStyle = "#ffffff";
    context.fillRect(Math.round((width * at - 1) * ratio), 0, 2 * ratio, this.canvas.height);
  }

  drawLines(times, series, width, height, ratio, duration, isShared) {
    const context = this.lines.getContext("2d");
    context.scale(ratio, ratio);
    const ranges = series.map(({ values }) => rangeOf(values));
    const shared = ranges.reduce((all, [low, high]) => [Math.min(all[0], low), Math.max(all[1], high)], [0, 0]);
    series.forEach(({ values, color }, k) => {
      const [least, most] = isShared ? shared : ranges[k];
      const heightOf = (value) => height - 3 - ((height - 6) * (value - least)) / (most - least || 1);
      context.strokeStyle = color;
      context.lineWidth = 1.5;
      context.beginPath();
      strokeValues(context, times, values, width / duration, heightOf);
      context.stroke();
    });
  }
}

// The least and the largest value, and 0.
function rangeOf(values) {
  let [least, most] = [0, 0];
  for (let i = 0; i < values.length; ++i) {
    if (!Number.isFinite(values[i])) continue;
    least = Math.min(least, values[i]);
    most = Math.max(most, values[i]);
  }
  return [least, most];
}

// The way of the line: of all values in a column of pixels the least and the largest, so that long histories cost no
// more than short ones. Where values are missing it is interrupted.
function strokeValues(context, times, values, scale, heightOf) {
  let isGoingOn = false;
  for (let i = 0; i < values.length; ) {
    if (!Number.isFinite(values[i])) {
      isGoingOn = false;
      ++i;
      continue;
    }
    const x = scale * times[i];
    let [least, most] = [values[i], values[i]];
    let isFalling = false;
    const column = Math.floor(x);
    for (++i; i < values.length && Number.isFinite(values[i]) && Math.floor(scale * times[i]) === column; ++i) {
      if (values[i] < least) isFalling = true;
      if (values[i] > most) isFalling = false;
      least = Math.min(least, values[i]);
      most = Math.max(most, values[i]);
    }
    const [first, second] = isFalling ? [most, least] : [least, most];
    if (isGoingOn) context.lineTo(x, heightOf(first));
    else context.moveTo(x, heightOf(first));
    context.lineTo(x, heightOf(second));
    isGoingOn = true;
  }
}
