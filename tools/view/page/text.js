// Text on the page.

export const element = (id) => document.getElementById(id);

export function number(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const isSmall = value !== 0 && Math.abs(value) < 1e-4;
  return isSmall ? value.toExponential(2) : Number(value.toPrecision(digits)).toLocaleString("en-US", { maximumFractionDigits: 8 });
}

// Names and values, as a list of definitions.
export function list(target, rows) {
  target.replaceChildren(...rows.flatMap(([name, value]) => {
    const dt = document.createElement("dt");
    const dd = document.createElement("dd");
    dt.textContent = name;
    dd.textContent = value;
    return [dt, dd];
  }));
}
