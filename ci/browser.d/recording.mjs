// The page over recordings (`hil serve A.mcap [B.mcap]`) in Chromium: any moment by slider and keys, speed, two side by side.
//
//   recording.mjs HIL [PICTURES]
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, rmSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { accessible } from "./axe.mjs";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [hil, pictures] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });
const folder = mkdtempSync(join(tmpdir(), "palpate-"));
const at = name => join(folder, name);
execFileSync(hil, ["run", "sphere-circle", "--set", "length_s=6", "--quiet", "--record", at("a.mcap")]);
execFileSync(hil, ["run", "sphere-circle", "--set", "length_s=4", "--illusion", "phantom", "--quiet", "--record", at("b.mcap")]);
writeFileSync(at("cut.mcap"), readFileSync(at("a.mcap")).subarray(0, 700000));

async function serve(...names) {
  const run = spawn(hil, ["serve", ...names.map(at), "--at", "0"], { stdio: ["ignore", "ignore", "pipe"] });
  const ended = new Promise(done => run.on("exit", done));
  const base = await new Promise((done, failed) => {
    let told = "";
    run.stderr.on("data", data => { told += data; const found = /(http:\S+\/)/.exec(told); if (found) done(found[1]); });
    ended.then(() => failed(new Error(told)));
  });
  return { base, async end() { run.kill("SIGINT"); assert.equal(await ended, 0); } };
}

async function open(base, { width = 1280, height = 900, scheme = "light" } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, reducedMotion: "reduce" });
  const page = await context.newPage(), wrong = [], own = [base, base.replace("http", "ws")];
  page.on("console", message => ["error", "warning"].includes(message.type()) && wrong.push(message.text()));
  page.on("pageerror", error => wrong.push(error.message));
  page.on("request", request => own.some(url => request.url().startsWith(url)) || request.url().startsWith("data:") || wrong.push(request.url()));
  page.on("websocket", socket => socket.url().startsWith(own[1]) || wrong.push(socket.url()));
  await page.goto(base);
  return { page, async close() { assert.deepEqual(wrong, [], base); await context.close(); } };
}

// The frame of a recording, or the page itself where there is one.
const there = frame => frame.waitForFunction(() => (palpate.recording ?? palpate).picture);
const now = frame => frame.evaluate(() => (palpate.recording ?? palpate).picture.now_us);
const shows = (frame, us) => frame.waitForFunction(t => { const r = palpate.recording ?? palpate; return r.picture?.now_us === t && !r.asked; }, us, { timeout: 10000 });
const fits = async (page, width) => assert(await page.evaluate(() => document.documentElement.scrollWidth) <= width, `${width}: wider than the screen`);
const picture = async (page, name) => pictures && page.screenshot({ path: join(pictures, `${name}.png`), fullPage: true });

async function everywhere() {
  const { base, end } = await serve("a.mcap");
  for (const [width, height] of [[390, 844], [1280, 900], [3840, 2160]])
    for (const scheme of ["light", "dark"]) {
      const { page, close } = await open(base, { width, height, scheme });
      await there(page);
      await page.evaluate(() => palpate.clock.go(3500000));
      await shows(page, 3500000);
      await fits(page, width);
      await accessible(page, `recording ${width} ${scheme}`);
      await picture(page, `recording-${width}-${scheme}`);
      await close();
    }
  await end();
  console.log("recording: everywhere ok");
}

async function anyMoment() {
  const { base, end } = await serve("a.mcap");
  const { page, close } = await open(base);
  await there(page);
  assert.equal(await now(page), 0);
  await page.waitForFunction(() => document.getElementById("used").textContent === "not recorded");
  await page.focus("#time");
  await page.keyboard.press("End");
  const last = await page.evaluate(() => palpate.clock.end);
  await shows(page, last);
  assert(last > 5.9e6 && last <= 6.1e6, `${last}`);
  assert(await page.evaluate(() => palpate.recording.plots.warmed.length) > 40, "temperatures of the time before");
  await page.keyboard.press("Home");
  await shows(page, 0);
  for (const _ of [1, 2, 3]) await page.keyboard.press("Shift+ArrowRight");
  await page.keyboard.press("ArrowRight");
  await shows(page, 3100000);
  await page.waitForFunction(() => document.getElementById("contacts").textContent.startsWith("contact at"));
  assert.match(await page.textContent("#felt-place"), /mm/);
  assert(await page.evaluate(() => palpate.recording.plots.bursts.length) > 20, "bursts of the time before");
  // The same picture by another way.
  const counts = () => page.evaluate(() => JSON.stringify([palpate.recording.picture.counts, palpate.recording.picture.contacts]));
  const before = await counts();
  await page.keyboard.press("End");
  await shows(page, last);
  await page.evaluate(() => palpate.clock.go(3100000));
  await shows(page, 3100000);
  assert.equal(await counts(), before);

  await page.selectOption("#speed-of", "10");
  await page.click("#play");
  await page.waitForFunction(() => palpate.clock.at >= palpate.clock.end && !palpate.clock.playing, null, { timeout: 20000 });
  await shows(page, last);
  await page.selectOption("#speed-of", "0.01");
  await page.evaluate(() => palpate.clock.go(3100000));
  await page.click("#play");
  await page.waitForFunction(() => palpate.clock.at > 3103000, null, { timeout: 20000 });
  await page.click("#play");
  await page.waitForFunction(() => palpate.recording.plots.pulsed.length > 0 || palpate.recording.plots.bursts.length > 0);
  const stands = await page.evaluate(() => palpate.clock.at);
  assert(stands < 3400000, `a hundredth: ${stands}`);
  await picture(page, "recording-slow");

  // A lost connection comes again where it was.
  await page.evaluate(() => palpate.recording.link.socket.close());
  await page.waitForFunction(() => document.getElementById("line").textContent.includes("lost"));
  await page.waitForFunction(() => document.getElementById("line").textContent === "");
  await page.evaluate(() => palpate.clock.go(2000000));
  await shows(page, 2000000);
  await close();
  await end();
  console.log("recording: any moment ok");
}

async function pair() {
  const { base, end } = await serve("a.mcap", "b.mcap");
  for (const [width, height] of [[390, 844], [900, 900], [1280, 900], [1920, 1200]])
    for (const scheme of ["light", "dark"]) {
      const { page, close } = await open(base, { width, height, scheme });
      await page.waitForFunction(() => palpate.pair?.frames.every(f => f.contentWindow.palpate?.picture), null, { timeout: 20000 });
      const frames = page.frames().filter(frame => frame !== page.mainFrame());
      assert.equal(frames.length, 2);
      await page.evaluate(() => palpate.clock.go(3100000));
      for (const frame of frames) await shows(frame, 3100000);
      await fits(page, width);
      const [a, b] = await page.evaluate(() => [...document.querySelectorAll("#pair iframe")].map(f => { const { left, top } = f.getBoundingClientRect(); return { left, top }; }));
      assert(width > 1000 ? a.top === b.top && a.left < b.left : a.left === b.left && a.top < b.top, JSON.stringify([width, a, b]));
      for (const frame of frames) await fits(frame, width);
      await accessible(page, `two recordings ${width} ${scheme}`);
      await picture(page, `recordings-${width}-${scheme}`);
      if (width === 1280) {
        const texts = await Promise.all(frames.map(frame => frame.textContent("#run")));
        assert.match(texts[0], /a\.mcap.*inverse|a\.mcap/);
        assert.match(texts[1], /b\.mcap.*phantom/);
        // The shorter one stays at its end.
        await page.evaluate(() => palpate.clock.go(palpate.clock.end));
        await shows(frames[0], await page.evaluate(() => palpate.clock.end));
        await frames[1].waitForFunction(() => palpate.picture.now_us === palpate.end);
        assert(await now(frames[1]) < await now(frames[0]));
        // Keys count in the frames too.
        await frames[1].locator("#notes").focus();
        await page.keyboard.press("Home");
        for (const frame of frames) await shows(frame, 0);
      }
      await close();
    }
  await end();
  console.log("recording: two ok");
}

async function damaged() {
  const { base, end } = await serve("cut.mcap");
  const { page, close } = await open(base);
  await there(page);
  assert.match(await page.textContent("#lacks"), /cut\.mcap is damaged: byte \d+.*cut short.*shown until \d/);
  await accessible(page, "a damaged recording");
  await picture(page, "recording-cut");
  await close();
  await end();
  console.log("recording: damaged ok");
}

await everywhere();
await anyMoment();
await pair();
await damaged();
await browser.close();
rmSync(folder, { recursive: true });
