// Laws of pages that play recordings, in a browser: they draw the bodies, play and go back to the same picture, know
// the body under the cursor, work by keys alone, and say in words what is wrong.
import { check, colors, command, folder, hues, isLegible, launch, openAt, picture, record, settle } from "./browser.mjs";
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";

function makePage(name, scene, steps, ...options) {
  const page = join(folder, `${name}.html`);
  execFileSync(command, ["export", record(name, scene, steps, ...options), "--quiet", "--out", page]);
  return page;
}

const open = (browser, file, state = "ready") =>
  openAt(browser, `file://${resolve(file)}`, state, (url) => /^(file|data|blob):/.test(url));

async function drawsPlaysAndGoesBack(browser) {
  const page = await open(browser, makePage("pile", "pile", 60, "--set", "bodies=150"));
  const counts = await colors(page);
  const background = Math.max(...Object.values(counts));
  assert.ok((await hues(page)) >= 5, "bodies have colors");
  assert.ok(background < 0.9 * 320 * 180, "the picture is not empty");
  const first = await picture(page);
  const time = () => page.evaluate(() => window.screePage.time);
  await page.click("#play");
  await page.waitForFunction(() => window.screePage.time > 0.2);
  await page.click("#play");
  const stopped = await time();
  await page.waitForTimeout(100);
  assert.equal(await time(), stopped, "it stands still after Pause");
  assert.ok((await picture(page)) !== first);
  await page.evaluate(() => { document.getElementById("view").focus(); });
  await page.keyboard.press("Home");
  assert.ok((await picture(page)) === first, "the first step looks as it did");
  await page.keyboard.press("End");
  const last = await picture(page);
  assert.ok(last !== first);
  assert.match(await page.textContent("#clock"), /^step 60, 1\.00 s$/);
  await page.keyboard.press("ArrowLeft");
  await settle(page);
  assert.match(await page.textContent("#clock"), /^step 59,/);
  await page.keyboard.press("ArrowRight");
  assert.ok((await picture(page)) === last, "a step back and on looks the same");
  await page.locator("#time").fill("0.5");
  await settle(page);
  assert.match(await page.textContent("#clock"), /^step (29|30),/);
  const [, half] = /^step (\d+)/.exec(await page.textContent("#clock"));
  await page.locator("#time").focus();  // its arrows are steps, too
  await page.keyboard.press("ArrowRight");
  await settle(page);
  assert.match(await page.textContent("#clock"), new RegExp(`^step ${Number(half) + 1},`));
  await page.locator("#grid").click();  // keys work on after a click on a control
  await page.keyboard.press("Home");
  await settle(page);
  assert.match(await page.textContent("#clock"), /^step 0,/);
  assert.match(await page.textContent("#world"), /contacts–/);  // no step was played yet
  assert.match(await page.textContent("#world"), /bodies151/);
  assert.deepEqual(page.errors, []);
  await page.close();
}

async function knowsTheBodyUnderTheCursor(browser) {
  const page = await open(browser, makePage("stack", "stack", 30, "--set", "bodies=5"));
  const places = await page.evaluate(() => {
    const { scene, model } = window.screePage;
    return scene.state.numbers.map((number) => {
      const place = scene.centerOf(number).project(scene.camera);
      return { index: model.bodies[number].index, x: (place.x + 1) / 2 * innerWidth, y: (1 - place.y) / 2 * innerHeight };
    });
  });
  assert.equal(places.length, 5);
  for (const { index, x, y } of places) {
    await page.mouse.click(x, y);
    await settle(page);
    assert.equal(await page.textContent("#chosen-name"), `Body ${index}`);
    assert.match(await page.textContent("#chosen-figures"), /typedynamic/);
  }
  await page.mouse.click(5, 300);
  assert.equal(await page.isHidden("#chosen"), true, "the sky is no body");
  await page.keyboard.press("n");
  await settle(page);
  assert.equal(await page.textContent("#chosen-name"), `Body ${places[0].index}`);
  const before = await picture(page);
  let last = before;
  for (const key of ["a", "w", "e", "Shift+D", "c", "s", "d", "q", "p", "]"]) {
    await page.keyboard.press(key);
    const next = await picture(page);
    assert.equal(next !== last, key !== "]", key);  // which is seen as it plays
    last = next;
  }
  assert.equal(await page.evaluate(() => window.screePage.rate), 2);
  await page.keyboard.press("[");
  assert.equal(await page.evaluate(() => window.screePage.rate), 1);
  for (const key of ["n", "r", "c", "c"]) await page.keyboard.press(key);
  assert.ok((await picture(page)) === before, "the first view is back");
  await page.keyboard.press("f");
  assert.equal(await page.isChecked("#follow"), true);
  await page.keyboard.press("f");
  await page.keyboard.press(" ");
  await page.waitForFunction(() => window.screePage.time > 0);
  assert.deepEqual(page.errors, []);
  await page.close();
}

// The bodies that a page says are there, and those whose middles are picked, but for what lies before them.
async function knowsBodiesThatComeAndGo(browser) {
  const page = await open(browser, makePage("spawning", "spawning", 120, "--set", "bodies=10", "--set", "life=40"));
  for (const share of [0, 0.4, 1]) {
    await page.evaluate((at) => window.screePage.goTo(at * window.screePage.model.duration), share);
    await settle(page);
    const seen = await page.evaluate(() => {
      const { scene, model, sample } = window.screePage;
      const moving = model.bodies.map((body, number) => ({ body, number }))
        .filter(({ body }) => body.type !== "fixed" && sample >= body.first && sample < body.first + body.count);
      const picked = moving.filter(({ number }) => {
        const place = scene.centerOf(number).project(scene.camera);
        return scene.pick(place.x, place.y) >= 0;
      });
      const meshes = [...scene.moving.meshes, ...scene.standing.meshes];
      return { moving: moving.length, picked: picked.length, told: model.stats.bodies[sample],
        fixed: model.bodies.filter((body) => body.type === "fixed").length,
        drawn: new Set(meshes.flatMap((mesh) => [...mesh.userData.bodies.slice(0, mesh.count)])).size };
    });
    assert.equal(seen.told, seen.moving + seen.fixed);
    assert.ok(seen.picked >= 0.9 * seen.moving, `${seen.picked} of ${seen.moving} can be picked`);
    assert.equal(seen.drawn, seen.told);
  }
  assert.deepEqual(page.errors, []);
  await page.close();
}

async function agreesWithTheRecording(browser) {
  const page = await open(browser, makePage("ragdolls", "ragdolls", 40, "--set", "ragdolls=3"));
  execFileSync(command, ["extract", join(folder, "ragdolls.scree"), "--quiet", "--signal", "position", "--out",
    join(folder, "ragdolls.csv")]);
  const rows = readFileSync(join(folder, "ragdolls.csv"), "utf8").trim().split("\n").slice(1)
    .map((line) => line.split(",").map(Number));
  const poses = await page.evaluate(() => {
    const clip = window.screePage.model;
    const pose = new Float32Array(7);
    return clip.bodies.flatMap((body) => clip.steps.map((step, sample) => {
      clip.poseAt(body, sample, 0, pose);
      return [step, body.index, ...pose];
    }));
  });
  const known = new Map(rows.map(([step, , body, x, y, z]) => [`${step} ${body}`, [x, y, z]]));
  assert.equal(poses.length, rows.length);
  for (const [step, body, x, y, z, qx, qy, qz, qw] of poses) {
    const [rx, ry, rz] = known.get(`${step} ${body}`);
    assert.ok(Math.hypot(x - rx, y - ry, z - rz) < 2e-3, `step ${step}, body ${body}`);
    assert.ok(Math.abs(Math.hypot(qx, qy, qz, qw) - 1) < 1e-3);
  }
  await page.close();
}

async function saysWhatIsWrong(browser) {
  const good = readFileSync(makePage("still", "stack", 2, "--set", "bodies=2"), "utf8");
  const at = good.indexOf('id="clip">') + 200;
  const damaged = join(folder, "damaged.html");
  writeFileSync(damaged, good.slice(0, at) + (good[at] === "A" ? "B" : "A") + good.slice(at + 1, at + 40) + good.slice(at + 44));
  const page = await open(browser, damaged, "error");
  assert.match(await page.textContent("#message"), /The animation in this page is damaged: /);
  await page.close();
  const plain = await launch(["--no-sandbox", "--disable-gpu", "--disable-software-rasterizer", "--disable-3d-apis"]);
  const without = await open(plain, join(folder, "still.html"), "error");
  assert.match(await without.textContent("#message"), /This browser cannot draw the page: it has no WebGL 2/);
  await plain.close();
}

async function keepsTextLegible(browser) {
  const page = await open(browser, join(folder, "stack.html"));
  await isLegible(page);
  await page.close();
}

const browser = await launch();
try {
  await check(browser, [drawsPlaysAndGoesBack, knowsTheBodyUnderTheCursor, knowsBodiesThatComeAndGo, agreesWithTheRecording,
    saysWhatIsWrong, keepsTextLegible]);
} finally {
  await browser.close();
}
