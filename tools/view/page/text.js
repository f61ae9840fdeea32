// Text on the page.

export const element = (id) => document.getElementById(id);

export function number(value, digits = 4) {
  return Number.isFinite(value) ? Number(value.toPrecision(digits)).toLocaleString("en-US", { maximumFractionDigits: 6 }) : "–";
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
