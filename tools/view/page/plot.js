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
    const width = this.canvas.clientWidth || this.canvas.width;
    const height = this.canvas.clientHeight || this.canvas.height;
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
    const all = isShared ? series.flatMap(({ values }) => values).filter(Number.isFinite) : undefined;
    for (const { values, color } of series) {
      const known = all ?? values.filter(Number.isFinite);
      const least = known.reduce((a, b) => Math.min(a, b), 0);
      const most = known.reduce((a, b) => Math.max(a, b), least);
      context.strokeStyle = color;
      context.lineWidth = 1.5;
      context.beginPath();
      values.forEach((value, i) => {
        if (!Number.isFinite(value)) return;
        const y = height - 3 - ((height - 6) * (value - least)) / (most - least || 1);
        context.lineTo((width * times[i]) / duration, y);
      });
      context.stroke();
    }
  }
}
