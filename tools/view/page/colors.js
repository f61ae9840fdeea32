// Colors of bodies, red, green and blue from 0 to 255.

const kPalette = [[226, 138, 66], [86, 140, 196], [206, 96, 86], [112, 168, 92], [232, 190, 84], [124, 112, 176],
  [84, 168, 164], [214, 140, 160], [160, 122, 92], [150, 186, 210], [178, 196, 110], [222, 168, 132]];
// Matplotlib's viridis at 0, 1/4, 1/2, 3/4 and 1.
const kViridis = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

export const kFixed = [168, 170, 172];
export const kOrange = [226, 138, 66];
export const kBlue = [86, 140, 196];
export const kChosen = [255, 255, 120];
export const kDiffers = [232, 48, 48];

export const paletteColor = (number) => {
  const place = (5 * Math.round(number)) % kPalette.length;
  return kPalette[place < 0 ? place + kPalette.length : place];
};

// What the colors mean, where they are no names.
export const kScales = {
  island: "bodies that contacts and joints connect have one color",
  color: "the highest color of a body's contacts, which is when in a pass the solver comes to them; gray: none",
  residual: "speed at which surfaces still come together: 1 µm/s dark, 1 m/s yellow",
  force: "force of all contacts: 1 N dark, 1 MN yellow",
  speed: "0 dark, 2.3 m/s green, 20 m/s yellow",
  sleep: "awake orange, asleep blue",
  distance: "0.1 µm dark, 1 m yellow",
};

const kScale = Array.from({ length: 1025 }, (_, i) => {
  const low = Math.min(3, i >> 8);
  return [0, 1, 2].map((part) => kViridis[low][part] + (i / 256 - low) * (kViridis[low + 1][part] - kViridis[low][part]));
});

// From 0 to 1.
export const shareColor = (share) => kScale[Math.round(1024 * Math.min(1, Math.max(0, share || 0)))];

// m/s: half of the way at 2.3, all of it at 20.
export const speedColor = (speed) => shareColor((speed / (speed + 3)) * (23 / 20));

// By decades between two numbers above 0.
export const decadeColor = (value, low, high) =>
  shareColor(value > 0 ? Math.log(value / low) / Math.log(high / low) : 0);
