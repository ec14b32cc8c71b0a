// The playground in Chromium: fingers, keyboard, what is felt, and a session that comes again to the bit.
//
//   playground.mjs SITE HIL [PICTURES]        # PALPATE_MINUTES: how long a finger touches in the check of memory
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { extname, join, resolve } from "node:path";
import { accessible } from "./axe.mjs";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [site, hil, pictures] = process.argv.slice(2).map(path => path && resolve(path));
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
const server = createServer((request, response) => {
  const name = request.url.split(/[?#]/)[0].slice(1) || "index.html";
  try {
    const bytes = readFileSync(join(site, name));
    // A page alone in its process has a clock of microseconds.
    response.writeHead(200, {
      "content-type": types[extname(name)] ?? "application/octet-stream",
      "cross-origin-opener-policy": "same-origin", "cross-origin-embedder-policy": "require-corp",
    }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise(done => server.listen(0, "127.0.0.1", done));
const base = `http://127.0.0.1:${server.address().port}/`;
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });

// A page that asks nobody else; what it complains about fails the check.
async function open({ url = base, width = 1280, height = 1000, scheme = "light", touch = false, prepare, ready = true } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, hasTouch: touch, reducedMotion: "reduce" });
  const page = await context.newPage(), wrong = [];
  page.on("console", message => ["error", "warning"].includes(message.type()) && wrong.push(message.text()));
  page.on("pageerror", error => wrong.push(error.message));
  page.on("request", request => request.url().startsWith(base) || /^(data|blob|file):/.test(request.url()) || wrong.push(request.url()));
  if (prepare) await page.addInitScript(prepare);
  await page.goto(url);
  if (ready) await page.waitForFunction(() => globalThis.palpate?.picture);
  return { page, wrong, async close() { assert.deepEqual(wrong, [], url); await context.close(); } };
}

const picture = (page, name) => pictures && page.screenshot({ path: join(pictures, `${name}.png`) });
const now = page => page.evaluate(() => palpate.now);
// Virtual time, not the wall's: a busy machine is slower, and the same.
const pass = async (page, us) => { const until = await now(page) + us; await page.waitForFunction(t => palpate.now >= t, until, { timeout: 60000 }); };
const felt = page => page.evaluate(() => palpate.finger.felt && { at: palpate.finger.felt.at_mm, level: palpate.finger.felt.level_db, target: palpate.finger.felt.target_mm });
const touches = page => page.evaluate(() => palpate.picture.fingers.map(f => f[1]));
const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

async function beyond(page) {
  return page.evaluate(() => {
    const width = document.documentElement.clientWidth;
    const out = [...document.querySelectorAll("body *:not(.spoken)")].filter(e => { const b = e.getBoundingClientRect(); return b.width && (b.right > width + 1 || b.left < -1); });
    return out.slice(0, 5).map(e => `${e.tagName} ${e.className}: ${e.textContent.slice(0, 30)}`);
  });
}

// Where a touch of the driving module's millimetres is on the screen.
async function screen(page, [x, y]) {
  return page.evaluate(([mx, my]) => {
    const box = document.getElementById("pad-canvas").getBoundingClientRect(), { x, y } = palpate.pad.scale();
    return { x: box.left + x(mx), y: box.top + y(my) };
  }, [x, y]);
}

async function twoFingers() {
  const { page, close } = await open({ touch: true });
  await page.locator("#pad").scrollIntoViewIfNeeded();
  const cdp = await page.context().newCDPSession(page);
  const send = async (type, points) => {
    const touchPoints = await Promise.all(points.map(async ([id, at, force]) => ({ id, ...(await screen(page, at)), force, radiusX: 8, radiusY: 8 })));
    await cdp.send("Input.dispatchTouchEvent", { type, touchPoints });
  };
  await send("touchStart", [[1, [-5, 5], 0.4]]);
  await send("touchStart", [[1, [-5, 5], 0.4], [2, [5, -3], 0.7]]);
  // A contact for each, near its finger.
  await pass(page, 600000);
  const [fingers, contacts] = [await touches(page), await page.evaluate(() => palpate.picture.contacts.map(c => c.on_mm))];
  assert.equal(contacts.length, 2, "a contact for each finger");
  for (const finger of fingers) assert(contacts.some(at => apart(at, finger) < 1), `${finger}: contacts at ${contacts.join("; ")}`);
  assert.match(await page.textContent("#felt-place"), /several contacts/);
  for (let n = 0; n <= 20; n++) {
    await send("touchMove", [[1, [-5 + n * 0.3, 5 - n * 0.2], 0.4], [2, [5, -3 + n * 0.1], 0.7]]);
    await pass(page, 20000);
  }
  assert.equal((await touches(page)).length, 2, "two fingers");
  const forces = await page.evaluate(() => [...palpate.pad.fingers.values()].map(f => f.force));
  assert(forces.some(f => Math.abs(f - 0.8) < 0.02) && forces.some(f => Math.abs(f - 1.4) < 0.02), `pressure is force: ${forces}`);
  await picture(page, "playground-two-fingers");
  await send("touchEnd", [[1, [1, 1], 0.4]]);
  // The pulses of a contact, and one more onset until they are scored.
  await pass(page, 1.5e6);
  const [[touch], met] = [await touches(page), await felt(page)];
  assert(met?.level >= 0, `felt: ${JSON.stringify(met)}`);
  assert(apart(met.at, touch) < 1, `felt at ${met.at}, touched at ${touch}`);
  assert.equal(await page.textContent("#felt-from"), "From the true place");
  await send("touchEnd", []);
  await pass(page, 1e6);
  assert.deepEqual(await touches(page), []);
  await close();
}

async function mouseAndShare() {
  const { page, close } = await open();
  for (const [at, shift] of [[[-3, -3], true], [[4, 4], false]]) {
    const { x, y } = await screen(page, at);
    if (shift) await page.keyboard.down("Shift");
    await page.mouse.move(x, y);
    await page.mouse.down();
    if (shift) { await page.mouse.up(); await page.keyboard.up("Shift"); }
  }
  for (let n = 0; n < 25; n++) {
    const { x, y } = await screen(page, [4 - n * 0.2, 4 - n * 0.1]);
    await page.mouse.move(x, y);
    await pass(page, 20000);
  }
  assert.equal((await touches(page)).length, 2, "one left with Shift, one dragged");
  await page.mouse.wheel(0, -300);
  await page.mouse.up();
  await pass(page, 300000);
  await page.click("#share");
  await page.waitForFunction(() => /digest \w{16}/.test(document.getElementById("share-what").textContent), null, { timeout: 60000 });
  const text = await page.inputValue("#share-link");
  const digest = /digest (\w{16})/.exec(await page.textContent("#share-what"))[1];
  await picture(page, "playground-share");
  await accessible(page, "playground, share");

  // The link opens the same session, whose scene a run in the page and a native run repeat.
  const other = await open({ url: text });
  const again = await other.page.evaluate(() => palpate.loop.ask({ do: "run", ...palpate.settings.chosen() }));
  assert.equal(again.schedule, digest, "the link's digest");
  await pass(other.page, 2e6);
  assert((await other.page.evaluate(() => palpate.panels.count)) > 5);
  await other.close();
  const [saved] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  const folder = mkdtempSync(join(tmpdir(), "palpate-"));
  try {
    const scene = join(folder, "touched.toml");
    await saved.saveAs(scene);
    const command = /^# hil (.*)$/m.exec(readFileSync(scene, "utf8"))[1].split(" ").map(word => (word === "touched.toml" ? scene : word));
    execFileSync(hil, [...command, "--quiet", "--record", join(folder, "s.jsonl")]);
    assert.equal(readFileSync(join(folder, "s.jsonl"), "utf8").split("\n").slice(1).join("\n"), again.lines.split("\n").slice(1).join("\n"), "hil run repeats it to the bit");
    // The file opens as well, and so does one that is none, with a sentence.
    await page.setInputFiles("#open", scene);
    await page.waitForFunction(() => palpate.head.scene === "idle-touched");
    writeFileSync(join(folder, "none.toml"), "this is no log");
    await page.evaluate(() => document.getElementById("share-dialog").showModal());
    await page.setInputFiles("#open", join(folder, "none.toml"));
    await page.waitForFunction(() => /expected/.test(document.getElementById("alert").textContent));
  } finally {
    rmSync(folder, { recursive: true });
  }
  await close();
}

async function keyboard() {
  const { page, close } = await open();
  await page.focus("#pad");
  for (const key of ["ArrowRight", "ArrowRight", "Shift+ArrowUp", " ", "+", "+", "]"]) await page.keyboard.press(key);
  await pass(page, 1e6);
  const pressed = await page.evaluate(() => [...palpate.pad.fingers.values()]);
  assert.equal(pressed.length, 1);
  assert(pressed[0].x === 1 && pressed[0].y === 2 && pressed[0].force > 0.9, JSON.stringify(pressed));
  assert(await page.evaluate(() => palpate.picture.contacts.length) === 1, "a contact by keys");
  await page.keyboard.press(" ");
  await page.keyboard.press("p");
  const at = await now(page);
  await page.keyboard.press(".");
  assert.equal(Math.round(await now(page) - at), Math.round(await page.evaluate(() => palpate.head.period_ns / 1000)), "one period");
  await page.keyboard.press("p");
  await pass(page, 300000);
  assert.deepEqual(await touches(page), []);
  // The tour of six steps, by keys alone.
  await page.click("#tour");
  for (let step = 1; step <= 6; step++) {
    assert.match(await page.textContent("#tour-where"), new RegExp(`${step} of 6`));
    if (step === 1) await accessible(page, "playground, tour");
    await page.keyboard.press("Enter");
  }
  assert(await page.isHidden("#tour-card"));
  await close();
}

async function choices() {
  const { page, close } = await open();
  await page.click("[data-path=sphere-circle]");
  await pass(page, 2.5e6);
  const met = await felt(page);
  assert(met?.level >= 0 && apart(met.at, met.target) < 2, JSON.stringify(met));
  await page.click("summary");
  // The published law and drive: the guard limits them, and without it the limits are passed.
  await page.selectOption("[name=scene]", "rest-on-wire");
  await page.selectOption("[name=bench]", "thesis");
  await page.selectOption("[name=illusion]", "phantom");
  await page.waitForFunction(() => document.querySelector("#notes .limiter"), null, { timeout: 60000 });
  await page.check("[name=observe]");
  await page.waitForFunction(() => document.querySelector("#used .over"), null, { timeout: 60000 });
  assert(await page.isVisible("#observed"));
  await picture(page, "playground-observed");
  await accessible(page, "playground, observed and with choices open");
  await page.selectOption("[name=scene]", "texture-wood");
  await page.waitForFunction(() => palpate.head.scene === "texture-wood");
  await close();
}

// A bench of motors, touched and on its own scene: nothing of wires is shown, and what is said is of motors.
async function motors() {
  for (const [width, height, touch] of [[1280, 1000, false], [390, 844, true]]) {
    const { page, close } = await open({ width, height, touch });
    await page.click("summary");
    await page.selectOption("[name=scene]", "coins-along");
    await page.waitForFunction(() => palpate.head.bench === "lra-8" && palpate.head.motors);
    assert(await page.isDisabled("[name=wires]") && await page.isDisabled("[name=observe]"));
    await page.click("summary");
    await pass(page, 2.5e6);
    const met = await felt(page);
    assert(met?.level > 30 && apart(met.at, met.target) < 1, JSON.stringify(met));
    assert(await page.isHidden("#panel-warm"));
    assert.match(await page.innerText("#panel-pulses"), /Bursts of each motor/);
    assert.doesNotMatch(await page.innerText("#panel-finger"), /wire/i);
    const used = await page.evaluate(() => palpate.picture.used);
    assert.deepEqual(used.map(([key]) => key), ["displacement", "coil-heat", "burst", "duty"]);
    assert(used.every(([, share]) => share >= 0 && share <= 1), JSON.stringify(used));
    assert(Number.parseFloat(await page.textContent("#used-displacement em")) > 0, "a motor's amplitude is counted");
    assert.deepEqual(await beyond(page), [], `motors ${width}`);
    await picture(page, `playground-motors-${width}`);
    await accessible(page, `playground, motors at ${width}`);
    // Each other bench of motors opens by itself, under a finger of one's own.
    await page.click("summary");
    for (const [bench, count] of [["voice-coil-8", 8], ["lra-grid-4x3", 12]]) {
      await page.selectOption("[name=scene]", "idle");
      await page.selectOption("[name=bench]", bench);
      await page.waitForFunction(bench => palpate.head.bench === bench, bench);
      assert.equal(await page.evaluate(() => palpate.head.wires_mm.length), count);
      await page.focus("#pad");
      await page.keyboard.press(" ");
      await pass(page, 1e6);
      const own = await felt(page);
      assert(own?.level > 20, `${bench}: ${JSON.stringify(own)}`);
    }
    await picture(page, `playground-motors-back-${width}`);
    await page.selectOption("[name=illusion]", "inverse");
    await page.waitForFunction(() => /a law for motors/.test(document.getElementById("alert").textContent));
    await page.selectOption("[name=bench]", "emulated");
    await page.waitForFunction(() => palpate.head.bench === "emulated" && !palpate.head.motors);
    assert(await page.isVisible("#panel-warm") && await page.isEnabled("[name=wires]"));
    await close();
  }
}

async function badInput() {
  const said = async (options, pattern) => {
    const { page, wrong, close } = await open({ ...options, ready: false });
    await page.waitForFunction(() => !document.getElementById("alert").hidden);
    assert.match(await page.textContent("#alert"), pattern);
    wrong.length = 0; // what a browser says of what it lacks
    await close();
  };
  const link = session => `${base}#s=${Buffer.from(session).toString("base64url")}`;
  const { deflateRawSync } = await import("node:zlib");
  await said({ url: `${base}#s=AAAA` }, /link is broken/);
  await said({ url: `${base}#hello` }, /holds no session/);
  await said({ url: link(deflateRawSync(JSON.stringify({ v: 99, bench: "emulated", set: [], text: "name = \"old\"\ndescription = \"of another version\"\n" }))) }, /another version/);
  const of = session => link(deflateRawSync(JSON.stringify(session))), session = { v: 1, bench: "emulated", set: [] };
  await said({ url: of({ ...session, text: "nothing of a scene" }) }, /the session/);
  await said({ url: of(null) }, /link is broken/);
  await said({ url: of({ v: 1, text: "name = \"short\"" }) }, /link is broken/);
  const touched = samples => `name = "log"\ndescription = "A hand's log"\nlength_s = 2.0\nreference_frames = 10\n[[touches]]\nstart_s = 0.6\npath = { kind = "hand", samples = ${samples} }\n`;
  await said({ url: of({ ...session, text: touched("[[900000, 0, 0, 900, 12000], [700000, 0, 0, 900, 12000]]") }) }, /the session.*expected/s);
  await said({ url: of({ ...session, text: touched("[[900000, 0, 0]]") }) }, /the session/);
  // What another version's link has in common is opened: here neither its bench nor what it sets.
  const nearest = await open({ url: of({ v: 99, bench: "gone", set: 3, text: touched("[[900000, 0, 0, 900, 12000]]") }) });
  assert.match(await nearest.page.textContent("#alert"), /another version/);
  assert.equal(await nearest.page.evaluate(() => `${palpate.head.scene} ${palpate.head.bench}`), "log emulated");
  await nearest.close();
  await said({ prepare: () => { delete globalThis.WebAssembly; } }, /no WebAssembly/);
  await said({ prepare: () => { WebAssembly.instantiate = () => Promise.reject(new WebAssembly.CompileError("of its own")); } }, /cannot run the module/);
  await said({ url: `file://${join(site, "index.html")}` }, /palpate\.html/);
  const alone = await open({ url: `file://${join(site, "palpate.html")}` });
  await pass(alone.page, 200000);
  await alone.close();
}

// On a phone skin and finger are in view together.
async function phone() {
  const { page, close } = await open({ width: 390, height: 844, touch: true });
  const boxes = await page.evaluate(() => ["pad", "flat", "solid"].map(id => { const { top, bottom } = document.getElementById(id).getBoundingClientRect(); return [id, top, bottom]; }));
  for (const [id, top, bottom] of boxes) assert(top >= 0 && bottom <= 844, `${id} is out of view: ${top} to ${bottom}`);
  await close();
}

async function everywhere() {
  for (const [width, height] of [[390, 844], [768, 1024], [1280, 900], [2560, 1440], [3840, 2160]])
    for (const scheme of ["light", "dark"]) {
      const { page, close } = await open({ width, height, scheme });
      await page.click("[data-path=sphere-diagonal]");
      await pass(page, 2e6);
      assert.deepEqual(await beyond(page), [], `${width} ${scheme}`);
      await accessible(page, `playground ${width} ${scheme}`);
      await picture(page, `playground-${width}-${scheme}`);
      await close();
    }
}

// How long a picture takes, and the first one after the page is asked for.
async function measure() {
  const { page, close } = await open();
  const first = await page.evaluate(() => palpate.first);
  const { x, y } = await screen(page, [0, 0]);
  await page.mouse.move(x, y);
  await page.mouse.down();
  const took = { step: [], draw: [] };
  for (let n = 0; n < 450; n++) {
    await page.mouse.move(x + 60 * Math.sin(n / 9), y + 60 * Math.cos(n / 9));
    const [step, draw] = await page.evaluate(() => new Promise(done => requestAnimationFrame(() => done([palpate.took, palpate.drew]))));
    took.step.push(step);
    took.draw.push(draw);
  }
  const [step, draw] = [took.step, took.draw].map(all => all.slice(150).sort((a, b) => a - b)), of = (all, part) => all[Math.floor(part * (all.length - 1))].toFixed(2);
  console.log(`playground: a picture takes ${of(step, 0.5)} ms (median), ${of(step, 0.95)} ms (95 %), drawing it ${of(draw, 0.5)} ms; the first one came after ${first.toFixed(0)} ms`);
  await close();
}

// A finger that never rests, as fast as the page can: its memory grows by the log of the fingers alone.
async function memory() {
  const length = Number(process.env.PALPATE_MINUTES ?? 4);
  const { page, close } = await open();
  await page.click("#pause");
  const cdp = await page.context().newCDPSession(page);
  const held = async () => {
    await cdp.send("HeapProfiler.collectGarbage");
    const heap = (await cdp.send("Runtime.getHeapUsage")).usedSize;
    return { heap, module: await page.evaluate(() => palpate.loop.exports.memory.buffer.byteLength) };
  };
  const minutes = async count => page.evaluate(async minutes => {
    for (let n = 0; n < minutes * 3600; n++) {
      const a = palpate.now / 1e6;
      palpate.pad.put(0, { x: 5 * Math.sin(1.3 * a), y: 5 * Math.cos(a), force: 0.6 + 0.3 * Math.sin(3 * a), size: 12 });
      palpate.step(palpate.now + 1e6 / 60);
      if (n % 60 === 0) { palpate.draw(1); await new Promise(done => setTimeout(done)); }
    }
  }, count);
  await minutes(1);
  const before = await held();
  await minutes(length - 1);
  const after = await held(), mb = bytes => (bytes / 1e6).toFixed(1);
  assert.equal(await page.evaluate(() => palpate.failed), false);
  const grown = { heap: after.heap - before.heap, module: after.module - before.module };
  console.log(`playground: ${length} minutes of touching: module ${mb(before.module)} to ${mb(after.module)} MB, scripts ${mb(before.heap)} to ${mb(after.heap)} MB`);
  // At most 216000 samples of 40 bytes, in a list that doubles where it is full.
  assert(grown.module < 20e6 && grown.heap < 2e6, JSON.stringify(grown));
  await close();
}

for (const check of [twoFingers, mouseAndShare, keyboard, choices, motors, badInput, phone, everywhere, measure, memory]) {
  await check();
  console.log(`playground: ${check.name} ok`);
}
await browser.close();
server.close();
