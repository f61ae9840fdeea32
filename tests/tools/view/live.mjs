// Laws of `scree view`, in a browser: the page draws what the engine plays, goes back and forth to the same picture,
// knows the body under the cursor, changes the world, branches, compares, says in words what is wrong, and answers
// nobody else.
import { check, colors, command, folder, hues, isLegible, launch, openAt, picture, record, settle } from "./browser.mjs";
import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { request } from "node:http";
import { join } from "node:path";

const servers = [];

async function serve(...options) {
  const server = spawn(command, ["view", ...options, "--threads", "2"], { stdio: ["ignore", "pipe", "inherit"] });
  servers.push(server);
  const exited = new Promise((done) => server.once("exit", done));
  const url = await new Promise((done, fail) => {
    server.stdout.once("data", (text) => done(String(text).trim()));
    server.once("exit", (code) => fail(new Error(`scree view ended with ${code}`)));
  });
  const end = async () => {
    server.kill();
    assert.equal(await exited, 0, "the server ends as it should");
  };
  return { url, end, port: new URL(url).port };
}

const open = (browser, { url, port }, state = "ready") =>
  openAt(browser, url, state, (asked) => /^(data|blob):/.test(asked) || new URL(asked).host === `127.0.0.1:${port}`);

// Until the page shows a step, and nothing is on its way.
async function goTo(page, step) {
  await page.evaluate((to) => window.screePage.goToStep(to), step);
  await shows(page, step);
}
async function shows(page, step) {
  await page.waitForFunction((to) => window.screePage.stepNumber === to && !window.screePage.model.isWaiting &&
    window.screePage.model.frameOf(window.screePage.model.track, to), step);
  await settle(page);
}
async function playTo(page, step) {
  await page.evaluate(() => { window.screePage.play(true); });
  await page.waitForFunction((to) => window.screePage.stepNumber >= to, step);
  await page.evaluate(() => { window.screePage.play(false); });
  await settle(page);
}

// What is on the screen: by BodyId::index, of bodies that may move.
const bodies = (page) => page.evaluate(() => {
  const { scene, model } = window.screePage;
  return [...scene.state.numbers].map((number, i) => {
    const place = scene.centerOf(number).project(scene.camera);
    return { number, index: model.bodies[number].index, position: [...scene.state.poses.slice(7 * i, 7 * i + 3)],
      x: ((place.x + 1) / 2) * innerWidth, y: ((1 - place.y) / 2) * innerHeight };
  });
});
const bodyAt = async (page, index) => (await bodies(page)).find((body) => body.index === index);
const tracks = (page) => page.evaluate(() => window.screePage.model.tracks);

async function playsASceneAndScrubsBack(browser) {
  const server = await serve("pile", "--set", "bodies=150", "--port", "0");
  const page = await open(browser, server);
  const counts = await colors(page);
  assert.ok((await hues(page)) >= 5, "bodies have colors");
  assert.ok(Math.max(...Object.values(counts)) < 0.9 * 320 * 180, "the picture is not empty");
  const first = await picture(page);
  await playTo(page, 40);
  await goTo(page, 30);
  const middle = await picture(page);
  assert.ok(middle !== first);
  await page.evaluate(() => document.getElementById("view").focus());
  await page.keyboard.press("Home");
  await shows(page, 0);
  assert.ok((await picture(page)) === first, "the first step looks as it did");
  // What the page has kept is forgotten: the server plays the step again from its recording.
  await page.evaluate(() => { window.screePage.model.frames.clear(); window.screePage.model.asked = ""; });
  await goTo(page, 30);
  assert.ok((await picture(page)) === middle, "a step that was played again looks as it did");
  await page.keyboard.press("ArrowLeft");
  await shows(page, 29);
  await page.keyboard.press("ArrowRight");
  await shows(page, 30);
  assert.ok((await picture(page)) === middle);
  assert.match(await page.textContent("#world"), /bodies151awake150contacts\d/);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function showsARecordingBitByBit(browser) {
  const recording = record("chain", "ragdolls", 45, "--set", "ragdolls=2", "--keyframes", "20");
  execFileSync(command, ["extract", recording, "--quiet", "--signal", "position", "--out", join(folder, "chain.csv")]);
  const known = new Map(readFileSync(join(folder, "chain.csv"), "utf8").trim().split("\n").slice(1)
    .map((line) => line.split(",").map(Number)).map(([step, , body, ...place]) => [`${step} ${body}`, place]));
  const server = await serve(recording, "--port", "0");
  const page = await open(browser, server);
  for (const step of [0, 45, 13, 44, 20, 21, 1]) {
    await goTo(page, step);
    const seen = await bodies(page);
    assert.ok(seen.length > 10);
    for (const { index, position } of seen) {
      assert.deepEqual(position, known.get(`${step} ${index}`).slice(0, 3).map(Math.fround), `step ${step}, body ${index}`);
    }
  }
  // The figures of all steps are known though few of them were looked at.
  await page.waitForFunction(() => window.screePage.model.series.contacts.filter(Number.isFinite).length === 45);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function tellsOfTheBodyUnderTheCursor(browser) {
  const server = await serve("stack", "--set", "bodies=4", "--port", "0");
  const page = await open(browser, server);
  await playTo(page, 30);
  for (const { index, x, y } of await bodies(page)) {
    await page.mouse.click(x, y);
    await settle(page);
    await page.waitForFunction(() => /contact force/.test(document.getElementById("chosen-figures").textContent));
    assert.equal(await page.textContent("#chosen-name"), `Body ${index}`);
    assert.match(await page.textContent("#chosen-contacts"), /touches body \d+ with [\d.,]+ N, color \d/);
  }
  for (const kind of ["contacts", "joints", "bounds", "axes", "centers"]) {
    const before = await page.evaluate(() => window.screePage.scene.marks.count);
    await page.check(`#marks input[value="${kind}"]`);
    await settle(page);
    const after = await page.evaluate(() => window.screePage.scene.marks.count);
    if (kind === "joints") assert.equal(after, before, "a stack has none");
    else assert.ok(after > before, kind);
  }
  let last = await picture(page);
  for (const color of ["sleep", "speed", "island", "color", "residual", "force", "island", "color", "type"]) {
    await page.selectOption("#colors", color);
    await page.waitForFunction(() => window.screePage.model.isFresh(window.screePage.scene.state.frame));
    const next = await picture(page);
    assert.ok(next !== last, color);
    last = next;
  }
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function tellsOfJoints(browser) {
  const server = await serve("ragdolls", "--set", "ragdolls=1", "--port", "0");
  const page = await open(browser, server);
  await playTo(page, 10);
  await page.evaluate(() => document.getElementById("view").focus());
  await page.keyboard.press("n");
  await page.waitForFunction(() => /joint \d+, [a-z ]+, with body \d+: [\d.,]+ N, [\d.,]+ N m/.test(document.getElementById("chosen-contacts").textContent));
  const before = await page.evaluate(() => window.screePage.scene.marks.count);
  await page.check('#marks input[value="joints"]');
  await settle(page);
  assert.ok((await page.evaluate(() => window.screePage.scene.marks.count)) > before);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function touchesTheWorld(browser) {
  const server = await serve("stack", "--set", "bodies=3", "--port", "0");
  const page = await open(browser, server);
  await playTo(page, 20);
  const boxes = (await bodies(page)).map(({ number }) => number);
  const count = boxes.length;
  const top = (await bodies(page)).sort((a, b) => b.position[1] - a.position[1])[0];
  await page.check('#tools input[value="drag"]');
  await page.mouse.move(top.x, top.y);
  await page.mouse.down();
  for (let i = 1; i <= 12; ++i) {
    await page.mouse.move(top.x, top.y - 12 * i);
    await page.waitForTimeout(50);
  }
  await page.waitForFunction(([number, height]) => {
    const { state } = window.screePage.scene;
    return state.poses[7 * state.numbers.indexOf(number) + 1] > height + 0.3;
  }, [top.number, top.position[1]]);
  assert.equal((await tracks(page)).length, 1, "the end of a live track is changed where it is");
  await page.mouse.up();
  await page.evaluate(() => window.screePage.play(false));
  await page.keyboard.press("g");
  await page.waitForFunction((before) => window.screePage.scene.state.numbers.length === before + 1, count);
  await page.evaluate(() => window.screePage.play(false));
  await settle(page);
  await page.evaluate((number) => window.screePage.choose(number), top.number);
  await page.keyboard.press("Delete");
  await page.waitForFunction((number) => !window.screePage.scene.state.numbers.includes(number), top.number);
  await page.click("#settings summary");
  await page.fill("#gravity", "0, 5, 0");
  await page.fill("#substeps", "2");
  await page.click("#apply");
  const heights = async () => (await bodies(page)).filter(({ number }) => boxes.includes(number))
    .reduce((sum, { position }) => sum + position[1], 0);
  const before = await heights();
  const { last } = (await tracks(page))[0];
  await playTo(page, last + 30);
  assert.ok((await heights()) > before + 0.5, "what gravity pulls up rises");
  await page.fill("#substeps", "65");
  await page.click("#apply");
  await page.waitForFunction(() => /substeps.*65/.test(document.getElementById("notice").textContent));
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function branchesAndSavesBranches(browser) {
  const server = await serve(record("fork", "pile", 80, "--set", "bodies=60"), "--port", "0");
  const page = await open(browser, server);
  const watcher = await open(browser, server);
  await goTo(page, 80);
  const end = await picture(page);
  await goTo(page, 40);
  await page.evaluate(() => document.getElementById("view").focus());
  await page.keyboard.press("b");
  await page.waitForFunction(() => window.screePage.model.track === 1);
  // A branch in which nothing was changed has the same bits.
  await playTo(page, 80);
  await goTo(page, 80);
  assert.ok((await picture(page)) === end, "the same future looks the same");
  await page.selectOption("#beside", "0");
  await page.waitForFunction(() => /same bits/.test(document.getElementById("parting").textContent));
  await page.fill("#track-name", "nothing changed");
  await page.keyboard.press("Enter");
  await watcher.waitForFunction(() => window.screePage.model.tracks[1]?.name === "nothing changed");
  // One that was changed parts from it in the step after the change, and shares the past.
  await goTo(page, 50);
  await page.check('#tools input[value="delete"]');
  const [target] = (await bodies(page)).sort((a, b) => b.position[1] - a.position[1]);
  await page.evaluate(([number, index]) => {
    window.screePage.touch.send({ kind: "delete", body: index });
  }, [target.number, target.index]);
  await page.waitForFunction(() => window.screePage.model.track === 2);
  await playTo(page, 60);
  await page.selectOption("#beside", "0");
  await page.waitForFunction(() => /They part at step 51/.test(document.getElementById("parting").textContent));
  await goTo(page, 20);
  assert.equal((await bodies(page)).length, 60, "the past is that of the recording");
  const saved = join(folder, "branch.scree");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#tracks li:nth-child(3) a")]);
  await download.saveAs(saved);
  execFileSync(command, ["replay", saved, "--verify", "--quiet"]);
  const info = execFileSync(command, ["info", saved, "--json", "-"], { stdio: ["ignore", "pipe", "ignore"] });
  assert.equal(JSON.parse(info).first_step, 50);
  // A recording that begins later is compared from there on.
  const both = await serve(join(folder, "fork.scree"), saved, "--port", "0");
  const pair = await open(browser, both);
  await pair.waitForFunction(() => {
    const { model, live } = window.screePage;
    return live.comparison.steps.size === Math.min(...model.tracks.map(({ last }) => last)) - 50 + 1;
  });
  await pair.close();
  await both.end();
  await page.fill("#page-every", "2");
  const [html] = await Promise.all([page.waitForEvent("download"), page.click("#tracks li:nth-child(3) a:last-child")]);
  const animation = join(folder, "branch.html");
  await html.saveAs(animation);
  const played = await openAt(browser, `file://${animation}`, "ready", (url) => /^(file|data|blob):/.test(url));
  assert.match(await played.textContent("#clock"), /^step 50,/);
  assert.deepEqual(await played.evaluate(() => window.screePage.model.steps.slice(0, 3)), [50, 52, 54]);
  await page.fill("#page-to", "20");
  await page.click("#tracks li:nth-child(3) a:last-child");
  await page.waitForFunction(() => /cannot be saved: .*20/.test(document.getElementById("notice").textContent));
  assert.deepEqual([...page.errors, ...watcher.errors, ...played.errors], []);
  for (const each of [page, watcher, played]) await each.close();
  await server.end();
}

async function drawsChaos(browser) {
  const server = await serve(record("chaos", "pile", 120, "--set", "bodies=80"), "--port", "0");
  const page = await open(browser, server);
  await goTo(page, 30);
  await page.keyboard.press("n");
  await page.click("#nudge");
  await page.waitForFunction(() => window.screePage.model.track === 1 && window.screePage.model.second === 0);
  await playTo(page, 120);
  await goTo(page, 120);
  await page.waitForFunction(() => /They part at step 31/.test(document.getElementById("parting").textContent));
  const apart = await page.evaluate(() => {
    const { comparison } = window.screePage.live;
    return [10, 31, 120].map((step) => comparison.at(step).largest);
  });
  assert.equal(apart[0], 0, "the past is shared");
  assert.ok(apart[1] < 1e-5, `a unit in the last place: ${apart[1]} m`);
  assert.ok(apart[2] > 100 * Math.max(apart[1], 1e-7), `it grows: ${apart[2]} m`);
  await page.selectOption("#graphed", "distance");
  await page.selectOption("#colors", "distance");
  await settle(page);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function findsWhatDiffFinds(browser) {
  const a = record("one", "pile", 60, "--set", "bodies=60");
  const b = record("other", "pile", 50, "--set", "bodies=60", "--substeps", "5");
  const { stdout } = spawnSync(command, ["diff", a, b, "--json", "-"]);
  const { divergence } = JSON.parse(stdout);
  const server = await serve(a, b, "--port", "0");
  const page = await open(browser, server);
  await page.waitForFunction(() => /They part/.test(document.getElementById("parting").textContent));
  assert.equal(await page.textContent("#parting"), `They part at step ${divergence.step}: ${divergence.difference}.`);
  await page.click("#to-parting");
  await shows(page, divergence.step);
  assert.equal(await page.textContent("#chosen-name"), `Body ${/body (\d+)/.exec(divergence.difference)[1]}`);
  await page.waitForFunction(() => window.screePage.live.comparison.steps.size === 51, undefined, { timeout: 20000 });
  const over = await picture(page);
  await page.check("#side-by-side");
  assert.ok((await picture(page)) !== over);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

// More fixed bodies than are drawn at once are drawn by cells, those far away as boxes: the ground looks nearly the same.
async function drawsManyFixedBodies(browser) {
  const server = await serve("large_world", "--set", "bodies=30000", "--port", "0");
  const page = await open(browser, server);
  const share = async () => {
    const counts = await colors(page);
    const sky = counts["11,12,12"] ?? 0;
    return 1 - sky / (320 * 180);
  };
  const drawn = () => page.evaluate(() => window.screePage.scene.standing.meshes.filter(({ visible }) => visible)
    .reduce((sum, { count }) => sum + count, 0));
  assert.equal(await drawn(), 30000);
  assert.ok((await page.evaluate(() => window.screePage.scene.standing.layers.length)) > 5, "cells");
  const whole = await picture(page);
  const all = await share();
  assert.ok(all > 0.1, `the ground is seen: ${all}`);
  await page.uncheck("#fine");
  await page.evaluate(() => window.screePage.drawCoarsely(2));
  await settle(page);
  const near = await drawn();
  assert.ok(near > 0 && near <= 5000, `drawn one by one: ${near}`);
  const some = await share();
  // Boxes around the others cover the same ground, and the gaps of a fifth between the bodies.
  assert.ok(some > 0.98 * all && some < 1.4 * all, `${some} of ${all}`);
  const inMemory = () => page.evaluate(() => window.screePage.scene.renderer.info.memory.geometries);
  const before = await inMemory();
  await page.check("#fine");
  assert.ok((await picture(page)) === whole, "no box is left of those far away");
  await page.evaluate(() => window.screePage.drawCoarsely(2));
  await settle(page);
  assert.equal(await inMemory(), before);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

// A wall among bullets that come from kilometers away: it is seen at first, and can be come close to.
async function looksAtWhatIsCloseTogether(browser) {
  const server = await serve("bullets", "--port", "0");
  const page = await open(browser, server);
  assert.ok((await hues(page)) >= 1, "the bricks are seen");
  for (let i = 0; i < 200; ++i) await page.keyboard.press("q");
  const [distance, size, near] = await page.evaluate(() => {
    const { orbit, model, scene } = window.screePage;
    return [orbit.distance, model.size, scene.camera.near];
  });
  assert.ok(distance <= 2 * size && near < 0.1 * size, `${distance} m from the target, ${near} m from the eye: bodies of ${size} m`);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function goesOnAfterALostConnection(browser) {
  const server = await serve(record("lost", "stack", 60, "--set", "bodies=8"), "--port", "0");
  const page = await open(browser, server);
  const known = () => page.evaluate(() => {
    const { model } = window.screePage;
    return [model.bodies.length, model.meshes.length, model.happened.length, model.series.times.length];
  });
  await page.waitForFunction(() => window.screePage.model.series.contacts.filter(Number.isFinite).length === 60);
  await goTo(page, 40);
  const before = await picture(page);
  const all = await known();
  assert.ok(all[2] > 0, "blocks that are let go hit each other");
  await page.evaluate(() => window.screePage.model.socket.close());
  await page.waitForFunction(() => !document.getElementById("notice").hidden);
  await page.evaluate(() => { window.screePage.model.frames.clear(); window.screePage.goToStep(20); });
  await page.waitForFunction(() => document.getElementById("notice").hidden);
  await shows(page, 20);  // what was looked for meanwhile
  await goTo(page, 40);
  assert.ok((await picture(page)) === before, "the same step looks the same");
  await page.waitForFunction(() => window.screePage.model.series.contacts.filter(Number.isFinite).length === 60);
  assert.deepEqual(await known(), all);
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

// Keys play, go back and forth, choose, color and branch; and Tab comes to all that can be used, in sight.
async function worksWithoutAMouse(browser) {
  const server = await serve("stack", "--set", "bodies=5", "--port", "0");
  const page = await open(browser, server);
  const press = async (...keys) => {
    for (const key of keys) await page.keyboard.press(key);
    await settle(page);
  };
  await page.evaluate(() => document.activeElement.blur());
  await press("Space");
  await page.waitForFunction(() => window.screePage.stepNumber >= 20);
  await press("Space");
  await page.waitForFunction(() => !window.screePage.isPlaying && window.screePage.stepNumber === window.screePage.model.last);
  await press("Home");
  await shows(page, 0);
  await press("ArrowRight", "ArrowRight", "ArrowLeft");
  await shows(page, 1);
  await press("n", "n", "p");
  assert.equal(await page.evaluate(() => window.screePage.scene.chosen >= 0 && !document.getElementById("chosen").hidden), true);
  await press("c", "]");
  assert.deepEqual(await page.evaluate(() => [window.screePage.scene.colorBy, window.screePage.rate]), ["type", 2]);
  await press("b");
  await page.waitForFunction(() => window.screePage.model.track === 1);
  for (const id of ["settings", "events-box"]) {
    await page.focus(`#${id} summary`);
    await press("Enter");
  }
  const usable = await page.evaluate(() => [...document.querySelectorAll("canvas[tabindex], button, select, input, a, summary")]
    .filter((each) => each.checkVisibility()).filter(({ type, checked }) => type !== "radio" || checked)
    .map((each, i) => { each.dataset.place = i; return each.id || each.textContent; }));
  assert.ok(usable.includes("apply"), "what Enter opens");
  const seen = new Set();
  for (let i = 0; i < 2 * usable.length; ++i) {
    await page.keyboard.press("Tab");
    const [place, isInSight] = await page.evaluate(() => {
      const each = document.activeElement;
      const box = each.getBoundingClientRect();
      return [each.dataset.place, getComputedStyle(each).outlineStyle !== "none" && box.top >= 0 && box.bottom <= innerHeight];
    });
    if (place === undefined) continue;
    assert.ok(isInSight, `${usable[place]} has the focus and is seen`);
    seen.add(Number(place));
  }
  assert.deepEqual(usable.filter((_, i) => !seen.has(i)), [], "what Tab does not come to");
  // In a field, keys write.
  await page.focus("#track-name");
  await page.keyboard.press("Control+A");
  await page.keyboard.type("bend c");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => window.screePage.model.tracks[1].name === "bend c");
  assert.equal((await tracks(page)).length, 2, "a letter in a name starts no branch");
  assert.deepEqual(page.errors, []);
  await page.close();
  await server.end();
}

async function runsOnWhenNobodyLooks(browser) {
  const server = await serve("stack", "--set", "bodies=3", "--port", "0");
  const page = await open(browser, server);
  await page.click("#settings summary");
  await page.fill("#run-to", "200");
  await page.click("#run");
  await page.close();
  const file = join(folder, "alone.scree");
  for (let last = 0, i = 0; last !== 200; ++i) {
    assert.ok(i < 100, `it has come to step ${last} only`);
    await new Promise((done) => setTimeout(done, 100));
    writeFileSync(file, Buffer.from(await (await fetch(`${server.url}recording/0`)).arrayBuffer()));
    last = JSON.parse(execFileSync(command, ["info", file, "--json", "-"], { stdio: ["ignore", "pipe", "ignore"] })).last_step;
  }
  await server.end();
}

async function saysWhatIsWrong(browser) {
  const server = await serve("stack", "--set", "bodies=2", "--port", "0");
  const page = await open(browser, server);
  await playTo(page, 10);
  await server.end();
  await page.waitForFunction(() => /server does not answer/.test(document.getElementById("notice").textContent));
  const next = await serve("stack", "--set", "bodies=5", "--port", server.port);
  await page.waitForFunction(() => document.body.dataset.state === "ready" && window.screePage?.scene.state?.numbers.length === 5);
  await next.end();
  await page.close();
  // A recording whose keyframes were changed plays, but cannot be gone to the middle of for what was not kept.
  const good = record("good", "pile", 200, "--set", "bodies=40", "--keyframes", "50");
  const bytes = readFileSync(good);
  for (let share = 0.3; share < 0.95; share += 0.02) bytes[Math.floor(share * bytes.length)] ^= 1;
  const damaged = join(folder, "changed.scree");
  writeFileSync(damaged, bytes);
  const third = await serve(damaged, "--port", "0");
  const broken = await open(browser, third);
  await broken.keyboard.press("n");
  await broken.evaluate(() => window.screePage.goToStep(150));
  await broken.waitForFunction(() => /changed\.scree: .*checksum/.test(document.getElementById("notice").textContent));
  assert.equal(await broken.evaluate(() => document.body.dataset.state), "ready");
  await broken.close();
  await third.end();
  for (const [options, words] of [
    [["nothing.scree"], /nothing\.scree/],
    [["pile", "--port", "70000"], /--port 70000/],
    [["pile", "--address", "here"], /--address here/],
    [["pile", "--set", "bodies=-1"], /bodies/],
    [[good, "--set", "bodies=1"], /a recording has no parameters/],
    [["pile", "--save", join(folder, "x.html")], /takes one recording/],
  ]) {
    const { status, stderr } = spawnSync(command, ["view", ...options], { encoding: "utf8", timeout: 20000 });
    assert.equal(status, 2, options.join(" "));
    assert.match(stderr, words);
  }
  const saved = join(folder, "saved.html");
  execFileSync(command, ["view", good, "--save", saved], { stdio: "ignore" });
  const still = await openAt(browser, `file://${saved}`, "ready", (url) => /^(file|data|blob):/.test(url));
  await still.close();
}

// The status of an answer.
const answer = (port, path, headers) => new Promise((done, fail) => {
  request({ host: "127.0.0.1", port, path, headers }, (response) => {
    response.resume();
    response.on("end", () => done(response.statusCode));
  }).on("upgrade", (response, socket) => {
    socket.destroy();
    done(101);
  }).on("error", fail).end();
});

async function answersNobodyElse() {
  const server = await serve("stack", "--port", "0");
  const upgrade = { Connection: "Upgrade", Upgrade: "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==" };
  const host = `localhost:${server.port}`;
  for (const [path, headers, status] of [
    ["/", { Host: host }, 200],
    ["/", { Host: "127.0.0.1:9000" }, 200],  // a tunnel
    ["/", { Host: "elsewhere.example" }, 403],
    ["/module/scree/main", { Host: host }, 200],
    ["/module/../CMakeLists.txt", { Host: host }, 404],
    ["/recording/7", { Host: host }, 400],
    ["/recording/x", { Host: host }, 404],
    ["/page/0?from=5&to=2", { Host: host }, 400],
    ["/nothing", { Host: host }, 404],
    ["/socket", { Host: host, Origin: `http://${host}`, ...upgrade }, 101],
    ["/socket", { Host: host, Origin: "http://elsewhere.example", ...upgrade }, 403],
    ["/socket", { Host: "elsewhere.example", Origin: "http://elsewhere.example", ...upgrade }, 403],
  ]) {
    assert.equal(await answer(server.port, path, headers), status, `${path} ${JSON.stringify(headers)}`);
  }
  await server.end();
}

async function keepsTextLegible(browser) {
  const server = await serve("stack", "--port", "0");
  const page = await open(browser, server);
  await page.selectOption("#graphed", "milliseconds");
  await page.evaluate(() => window.screePage.say("said"));
  for (const id of ["settings", "events-box"]) await page.click(`#${id} summary`);
  await page.keyboard.press("n");
  await isLegible(page);
  await page.close();
  await server.end();
}

process.on("exit", () => servers.forEach((server) => server.kill()));
const browser = await launch();
try {
  await check(browser, [playsASceneAndScrubsBack, showsARecordingBitByBit, tellsOfTheBodyUnderTheCursor, tellsOfJoints, touchesTheWorld,
    branchesAndSavesBranches, drawsChaos, findsWhatDiffFinds, drawsManyFixedBodies, looksAtWhatIsCloseTogether,
    goesOnAfterALostConnection, worksWithoutAMouse,
    runsOnWhenNobodyLooks, saysWhatIsWrong, answersNobodyElse, keepsTextLegible]);
} finally {
  await browser.close();
}
