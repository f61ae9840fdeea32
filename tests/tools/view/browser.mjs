// What the laws of pages share: a browser without a graphics card, and looking at pages.
//
// Programs that import this are called as: node FILE MODULES CHROMIUM COMMAND FOLDER: where npm has put
// playwright-core, the browser, the command scree, and a folder for files.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const [modules, chromium, command, folder] = process.argv.slice(2);
const playwright = createRequire(join(resolve(modules), "package.json"))("playwright-core");
const kDrawWithoutCard = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
export { command, folder };

export const launch = (args = kDrawWithoutCard) => playwright.chromium.launch({ executablePath: chromium, args });

export function record(name, scene, steps, ...options) {
  const recording = join(folder, `${name}.scree`);
  execFileSync(command, ["run", scene, "--steps", String(steps), "--quiet", "--record", recording, ...options]);
  return recording;
}

// `isAllowed`: whether the page may ask for an address.
export async function openAt(browser, address, state, isAllowed) {
  const page = await browser.newPage({ viewport: { width: 1024, height: 640 } });
  page.errors = [];
  page.on("pageerror", (error) => page.errors.push(error.message));
  page.on("request", (request) => {
    if (!isAllowed(request.url())) page.errors.push(`asks for ${request.url()}`);
  });
  await page.goto(address);
  await page.waitForFunction(() => document.body.dataset.state !== "loading");
  assert.equal(await page.evaluate(() => document.body.dataset.state), state);
  // Pictures are compared: what is drawn must not depend on the time that it takes.
  if (state === "ready") await page.check("#fine");
  await settle(page);
  return page;
}

// Until what was asked for is on the screen.
export const settle = (page) => page.evaluate(() => new Promise((done) =>
  requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));

// Pixels of the canvas by color, in steps of 16.
export const colors = (page) => page.evaluate(() => {
  const canvas = document.createElement("canvas");
  const view = document.getElementById("view");
  [canvas.width, canvas.height] = [320, 180];
  const context = canvas.getContext("2d");
  context.drawImage(view, 0, 0, 320, 180);
  const counts = {};
  const data = context.getImageData(0, 0, 320, 180).data;
  for (let i = 0; i < data.length; i += 4) {
    const key = [data[i] >> 4, data[i + 1] >> 4, data[i + 2] >> 4].join();
    counts[key] = (counts[key] ?? 0) + 1;
  }
  return counts;
});

export const picture = async (page) => {
  await settle(page);
  return page.evaluate(() => document.getElementById("view").toDataURL());
};

// How many of six hues a picture has in more than a thousandth of its pixels: gray has none.
export const hues = async (page) => {
  const counts = new Array(6).fill(0);
  for (const [key, count] of Object.entries(await colors(page))) {
    const [r, g, b] = key.split(",").map(Number);
    const [least, most] = [Math.min(r, g, b), Math.max(r, g, b)];
    if (most - least < 3) continue;
    const turn = most === r ? (g - b) / (most - least) : most === g ? 2 + (b - r) / (most - least) : 4 + (r - g) / (most - least);
    counts[Math.floor(turn + 6) % 6] += count;
  }
  return counts.filter((count) => count > 57).length;
};

// WCAG 2.1, 1.4.3, and that all of it is in the window, and nothing over anything else.
export async function isLegible(page) {
  const contrasts = await page.evaluate(() => {
    const channel = (value) => (value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
    const light = ([r, g, b]) => 0.2126 * channel(r / 255) + 0.7152 * channel(g / 255) + 0.0722 * channel(b / 255);
    const numbers = (color) => color.match(/[\d.]+/g).map(Number);
    const over = ([r, g, b, a = 1], below) => [r, g, b].map((part, i) => a * part + (1 - a) * below[i]);
    // What is behind an element; behind all is the picture, which may have any light.
    const behind = (each, picture) => {
      const layers = [];
      for (let at = each; at; at = at.parentElement) {
        const color = numbers(getComputedStyle(at).backgroundColor);
        if (color[3] === 0) continue;
        if (at === document.body || at === document.documentElement) break;
        layers.unshift(color);
      }
      return layers.reduce((below, layer) => over(layer, below), picture);
    };
    const hasText = (each) => each.tagName === "SELECT" || ["text", "number"].includes(each.type) ||
      [...each.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim() !== "");
    return [...document.querySelectorAll("#panel *, #transport *, #notice")]
      .filter((each) => hasText(each) && each.checkVisibility() && each.tagName !== "OPTION").map((each) => {
        const contrast = Math.min(...[[255, 255, 255], [0, 0, 0]].map((picture) => {
          const [text, ground] = [light(numbers(getComputedStyle(each).color)), light(behind(each, picture))];
          return (Math.max(text, ground) + 0.05) / (Math.min(text, ground) + 0.05);
        }));
        return [contrast, each.id || each.textContent.trim()];
      });
  });
  assert.ok(contrasts.length > 20);
  const [least, where] = contrasts.sort(([a], [b]) => a - b)[0];
  assert.ok(least >= 4.5, `contrast ${least} of ${where}`);
  for (const size of [{ width: 1280, height: 720 }, { width: 2560, height: 1080 }]) {
    await page.setViewportSize(size);
    await settle(page);
    const boxes = {};
    for (const id of ["panel", "transport", "view"]) {
      const box = (boxes[id] = await page.locator(`#${id}`).boundingBox());
      assert.ok(box.x >= 0 && box.y >= 0 && box.x + box.width <= size.width && box.y + box.height <= size.height, id);
      const overflow = await page.evaluate((name) => document.getElementById(name).scrollWidth - document.getElementById(name).clientWidth, id);
      assert.ok(overflow <= 0, `${id} is ${overflow} pixels narrower than what is in it`);
    }
    assert.ok(boxes.panel.y + boxes.panel.height <= boxes.transport.y, "the panel ends above the controls of time");
  }
}

export async function check(browser, laws) {
  for (const law of laws) {
    const start = Date.now();
    await law(browser);
    console.log(`${law.name}: ${Date.now() - start} ms`);
  }
}

mkdirSync(folder, { recursive: true });
