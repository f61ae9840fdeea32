// Lines over time on a small canvas.

// `series`: {values, color} each, drawn from its least to its largest value; values that are no numbers are left
// out. `at`: where the time stands, from 0 to 1.
export function plot(canvas, series, at) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth || canvas.width;
  const height = canvas.clientHeight || canvas.height;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.clearRect(0, 0, width, height);
  for (const { values, color } of series) {
    const known = values.filter(Number.isFinite);
    const least = Math.min(0, ...[known.reduce((a, b) => Math.min(a, b), 0)]);
    const most = known.reduce((a, b) => Math.max(a, b), least);
    context.strokeStyle = color;
    context.lineWidth = 1.5;
    context.beginPath();
    values.forEach((value, i) => {
      if (!Number.isFinite(value)) return;
      const x = (width * i) / Math.max(1, values.length - 1);
      const y = height - 3 - ((height - 6) * (value - least)) / (most - least || 1);
      context.lineTo(x, y);
    });
    context.stroke();
  }
  context.fillStyle = "#ffffff";
  context.fillRect(Math.round(width * at) - 1, 0, 2, height);
}
