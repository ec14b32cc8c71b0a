// A study's session in Chromium on emulated hardware (`hil study run`): every screen by touch, pen and keyboard alone, a lost
// tablet, a killed program, STOP; then the analysis of what was answered.
//
//   study.mjs HIL [PICTURES]
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { accessible } from "./axe.mjs";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [hil, pictures] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });
const here = mkdtempSync(join(tmpdir(), "palpate-study-")), out = join(here, "study"), file = join(here, "short.toml");

writeFileSync(file, `
name = "short"
description = "Every screen once"
consent = "You take part in a test.\\nYou may stop at any time."
instructions = "Answer what you are asked."
pause_s = 0.2
stimulus_s = 0.4
break_after = 3
break_s = 1.0
order = "as-listed"
questions = [
    { name = "hand", text = "Which hand wears the thimble?", choices = ["left", "right"] },
    { name = "warm", text = "Was it ever too warm?", choices = ["no", "yes"], after = true },
]
conditions = [
    { name = "secret-stroke", scene = "brush-strokes" },
    { name = "secret-wood", present = "wood" },
]
[absolute_threshold]
wires = [0]
method = "staircase"
trials = 2
simulated = { threshold_db = { mean = -14.0, sd = 3.3 }, wire_sd_db = 2.0, slope = { mean = 3.5, sd = 0.5 }, lapse = 0.04 }
[localisation]
wires = [3]
level_db = 0.0
repeats = 2
simulated = { bias_mm = { mean = 0.0, sd = 1.0 }, noise_mm = 2.0, slips = 0.0 }
[drawing]
conditions = ["secret-stroke"]
repeats = 2
simulated = { bias_mm = { mean = 0.0, sd = 0.5 }, scale = { mean = 1.0, sd = 0.05 }, noise_mm = 1.0, breaks_hz = 0.0 }
[rating]
scales = [{ name = "roughness", low = "very smooth", high = "very rough" }, { name = "friction", low = "very slippery", high = "very sticky" }]
conditions = ["secret-wood"]
compare = []
groups = "within"
repeats = 1
simulated = { rating = { mean = 3.0, sd = 0.5 }, noise = 0.5, difference = 0.0 }
`);

async function run(participant, { protocol = file, folder = out, more = [] } = {}) {
  const process = spawn(hil, ["study", "run", protocol, "--participant", participant, "--out", folder, "--at", "0", ...more], { stdio: ["ignore", "pipe", "pipe"] });
  let told = "";
  const ended = new Promise(done => process.on("exit", (code, signal) => done({ code, signal, told })));
  const base = await new Promise((done, failed) => {
    process.stderr.on("data", data => { told += data; const found = /participant: (http:\S+\/)/.exec(told); if (found) done(found[1]); });
    process.stdout.on("data", data => { told += data; });
    ended.then(() => failed(new Error(told)));
  });
  return { base, ended, process };
}

async function open(url, { width = 820, height = 1180, scheme = "light", touch = true } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, hasTouch: touch });
  const page = await context.newPage(), wrong = [], heard = [];
  page.on("console", message => ["error", "warning"].includes(message.type()) && !/WebSocket/.test(message.text()) && wrong.push(message.text()));
  page.on("pageerror", error => wrong.push(error.message));
  page.on("websocket", socket => socket.on("framereceived", frame => heard.push(frame.payload)));
  await page.goto(url);
  return { page, heard, async close() { assert.deepEqual(wrong, []); await context.close(); } };
}

const on = (page, screen) => page.waitForFunction(name => globalThis.shown === name, screen, { timeout: 30000 });
const shot = async (page, name) => { if (pictures) await page.screenshot({ path: join(pictures, `study-${name}.png`) }); };
const record = number => readFileSync(join(out, "records", `participant-${number}.jsonl`), "utf8").trim().split("\n").map(line => JSON.parse(line));

// From consent to the analysis, by touch; the experimenter looks on.
{
  const { base, ended } = await run("1");
  const { page, heard, close } = await open(base);
  const other = await open(`${base}experimenter`, { width: 1280, height: 900, touch: false });
  await on(page, "begin");
  // Before Begin the experimenter knows what it will be.
  await other.page.waitForFunction(() => /page is there/.test(document.getElementById("seat").textContent));
  const about = await other.page.evaluate(() => ["source", "protocol", "participant", "bench", "count", "dose", "step"].map(id => document.getElementById(id).textContent).join(" | "));
  assert.match(about, /^EMULATED \| short \| 1 \| emulated \| 0 of 7 trials, 0 void \| [\d.]+ % of what a session may have \| Waits until/);
  await accessible(other.page, "study experimenter before");
  await shot(other.page, "experimenter-before");
  await shot(page, "begin");
  await accessible(page, "study begin");
  await page.tap('text="Begin"');
  await on(page, "consent");
  assert(await page.isDisabled('text="Go on"'));
  await page.check("#agree");
  await accessible(page, "study consent");
  await shot(page, "consent");
  await page.tap('text="Go on"');
  await on(page, "question");
  await page.tap('text="right"');
  await on(page, "instructions");
  await page.tap('text="Go on"');
  await on(page, "play");
  for (let trial = 0; trial < 2; trial += 1) {
    await on(page, "interval");
    if (!trial) {
      await accessible(page, "study interval");
      await shot(page, "interval");
      await other.page.fill("#note", "first answer");
      await other.page.click("#noting button");
    }
    await page.locator(".row button").first().tap();
    await page.waitForFunction(() => globalThis.shown !== "interval");
  }
  await on(page, "place");
  const box = await page.locator("canvas").boundingBox();
  await page.touchscreen.tap(box.x + 0.5 * box.width, box.y + 0.2 * box.height);
  await shot(page, "place");
  await accessible(page, "study place");
  await page.tap('text="Done"');
  await on(page, "break");
  await shot(page, "break");
  await page.waitForFunction(() => !document.querySelector("main button").disabled);
  await page.tap('text="Go on"');
  await on(page, "place");
  await page.touchscreen.tap(box.x + 0.5 * box.width, box.y + 0.2 * box.height);
  const before = other.heard.length;
  await page.tap('text="Done"');

  // A stroke at 120 Hz: every point that the pen gave is in the record.
  await on(page, "path");
  const limits = other.heard.slice(before).map(text => JSON.parse(text).shows.rows?.find(([row]) => row === "omega")[1]);
  assert(new Set(limits).size > 5, `the experimenter saw the dose only as ${limits} while a stimulus was played`);
  const drawn = await page.evaluate(async () => {
    const canvas = document.querySelector("canvas"), box = canvas.getBoundingClientRect();
    const at = part => ({ clientX: box.left + box.width * 0.5, clientY: box.top + box.height * (0.9 - 0.8 * part), pointerId: 7, pointerType: "pen", isPrimary: true, bubbles: true });
    const capture = canvas.setPointerCapture;
    canvas.setPointerCapture = () => {};
    const points = 241;
    const begun = performance.now();
    canvas.dispatchEvent(new PointerEvent("pointerdown", at(0)));
    for (let n = 1; n < points; n += 1) {
      // As browsers do: one event a frame at 60 Hz that carries two points of the pen.
      const pair = [n, n + 1].filter(k => k < points).map(k => new PointerEvent("pointermove", at(k / (points - 1))));
      await new Promise(done => setTimeout(done, begun + (n * 1000) / 120 - performance.now()));
      canvas.dispatchEvent(Object.assign(new PointerEvent("pointermove", { ...at(n / (points - 1)), coalescedEvents: pair })));
      n += 1;
    }
    canvas.dispatchEvent(new PointerEvent("pointerup", at(1)));
    canvas.setPointerCapture = capture;
    return points;
  });
  await shot(page, "path");
  await accessible(page, "study path");
  await page.tap('text="Done"');
  await page.waitForFunction(() => globalThis.shown !== "path");
  await on(page, "path");
  const paths = () => record(1).filter(line => line.reply?.reply?.answer?.path).map(line => line.reply.reply.answer.path);
  const points = paths()[0].flat();
  assert.equal(points.length, drawn, "a point of the stroke is missing");
  const span = points.at(-1).t_ms - points[0].t_ms;
  assert(span > 1700 && span < 6000, `${span} ms`);
  // By touch, with a break between two strokes.
  await page.evaluate(() => {
    const canvas = document.querySelector("canvas"), box = canvas.getBoundingClientRect();
    canvas.setPointerCapture = () => {};
    for (const [from, to] of [[0.9, 0.6], [0.4, 0.1]]) {
      const at = y => ({ clientX: box.left + box.width * 0.5, clientY: box.top + box.height * y, pointerId: 3, pointerType: "touch", bubbles: true });
      canvas.dispatchEvent(new PointerEvent("pointerdown", at(from)));
      for (let n = 1; n <= 10; n += 1) canvas.dispatchEvent(new PointerEvent("pointermove", at(from + ((to - from) * n) / 10)));
      canvas.dispatchEvent(new PointerEvent("pointerup", at(to)));
    }
  });
  await page.tap('text="Done"');
  await on(page, "break");
  await page.waitForFunction(() => !document.querySelector("main button").disabled);
  await page.tap('text="Go on"');

  // What the experimenter lays under the finger.
  await other.page.waitForSelector("#lay:not([hidden])");
  assert.match(await other.page.textContent("#what"), /wood/);
  assert.match(await other.page.textContent("#count"), /6 of 7 trials/);
  await accessible(other.page, "study experimenter");
  await shot(other.page, "experimenter");
  await other.page.click("#laid");
  await on(page, "ratings");
  assert(await page.isDisabled('text="Done"'));
  await page.locator("fieldset").nth(0).locator("label").nth(1).tap();
  await page.locator("fieldset").nth(1).locator("label").nth(4).tap();
  await accessible(page, "study ratings");
  await shot(page, "ratings");
  await page.tap('text="Done"');
  await on(page, "question");
  await page.tap('text="no"');
  await on(page, "done");
  await shot(page, "done");
  for (const text of heard) assert(!/secret|wire|level|dB|emulated/.test(text), `the participant's page was told: ${text}`);
  await close();
  await other.close();
  const { code, told } = await ended;
  assert.equal(code, 0, told);
  assert(record(1).some(line => line.note?.text === "first answer"));
  console.log("study: from consent to the end ok");
}

// The keyboard alone; a tablet that is lost in the midst of a trial; a program that is killed and goes on.
{
  let session = await run("2");
  let { page, close } = await open(session.base, { width: 390, height: 844, scheme: "dark", touch: false });
  await on(page, "begin");
  await page.keyboard.press(" ");
  await on(page, "consent");
  await page.focus("#agree");
  await page.keyboard.press(" ");
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await on(page, "question");
  await page.keyboard.press("2");
  await on(page, "instructions");
  await page.keyboard.press(" ");
  await on(page, "interval");
  assert(await page.evaluate(() => document.documentElement.scrollWidth) <= 390, "wider than the screen");
  await shot(page, "interval-phone-dark");
  await page.keyboard.press("1");
  await page.waitForFunction(() => globalThis.shown !== "interval");
  await on(page, "interval");
  await page.evaluate(() => desk.socket.close());
  await on(page, "begin");
  await page.keyboard.press(" ");
  await on(page, "interval");
  const before = record(2);
  assert(before.some(line => /lost/.test(line.reply?.reply?.void ?? "")), "the lost trial is not in the record");
  session.process.kill("SIGKILL");
  await session.ended;
  await close();

  session = await run("2", { more: ["--resume"] });
  ({ page, close } = await open(session.base, { width: 390, height: 844, touch: false }));
  const other = await open(`${session.base}experimenter`, { touch: false });
  await on(page, "begin");
  await page.keyboard.press(" ");
  await on(page, "interval");
  assert.deepEqual(record(2).slice(0, before.length), before, "the record changed");
  await page.keyboard.press("2");
  await on(page, "place");
  await page.keyboard.press("ArrowUp");
  await page.keyboard.press("ArrowUp");
  await page.keyboard.press("Enter");
  await on(page, "break");
  await page.waitForFunction(() => !document.querySelector("main button").disabled);
  await page.keyboard.press(" ");
  await on(page, "place");
  await page.keyboard.press(" ");
  await page.keyboard.press("Enter");
  for (let trial = 0; trial < 2; trial += 1) {
    await on(page, "path");
    await page.keyboard.press(" ");
    for (let n = 0; n < 12; n += 1) await page.keyboard.press(n % 2 ? "ArrowUp" : "ArrowRight");
    await page.keyboard.press(" ");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => globalThis.shown !== "path");
  }
  await on(page, "break");
  await page.waitForFunction(() => !document.querySelector("main button").disabled);
  await page.keyboard.press(" ");
  await other.page.waitForSelector("#lay:not([hidden])");
  await other.page.click("#laid");
  await on(page, "ratings");
  await page.keyboard.press("3");
  await page.keyboard.press("6");
  await page.keyboard.press("Enter");
  await on(page, "question");
  await page.keyboard.press("1");
  await on(page, "done");
  await close();
  await other.close();
  assert.equal((await session.ended).code, 0);
  const numbers = record(2).filter(line => line.reply?.trial && !line.reply.reply.void).map(line => line.reply.trial.number);
  assert.deepEqual(numbers, [1, 2, 3, 4, 5, 6, 7], "trials after the kill are others");
  console.log("study: keyboard, lost tablet, kill ok");
}

// STOP while a wire is driven: from the finger on the button to outputs off.
{
  const { base, ended } = await run("3");
  const { page, close } = await open(base);
  await on(page, "begin");
  await page.tap('text="Begin"');
  await on(page, "consent");
  await page.check("#agree");
  await page.tap('text="Go on"');
  await page.tap('text="left"');
  await on(page, "instructions");
  await page.tap('text="Go on"');
  await on(page, "play");
  await page.waitForTimeout(850);
  const ms = await page.evaluate(() => new Promise(done => {
    const begun = performance.now();
    const look = () => globalThis.shown === "stopped" ? done(performance.now() - begun) : setTimeout(look, 1);
    document.getElementById("stop").dispatchEvent(new PointerEvent("pointerdown"));
    look();
  }));
  await shot(page, "stopped");
  await close();
  const { code, told } = await ended;
  assert.equal(code, 4, told);
  const said = record(3).find(line => line.stopped).stopped.text;
  const off = Number(/off (\d+) ms/.exec(said)[1]);
  assert(off <= 100, said);
  console.log(`study: STOP ok; outputs off after ${off} ms, the page said so after ${ms.toFixed(0)} ms`);
}

// A simulated person in front of the page: what is played they have from the experimenter's page, what they feel of it from a
// threshold and a psychometric function of their own. Their threshold comes back.
{
  const truth = -14, seated = join(here, "seated");
  writeFileSync(join(here, "seated.toml"), `
name = "seated"
description = "One wire's threshold"
pause_s = 0.1
stimulus_s = 0.2
[absolute_threshold]
wires = [0]
method = "quest-plus"
trials = 20
simulated = { threshold_db = { mean = ${truth}.0, sd = 3.3 }, wire_sd_db = 2.0, slope = { mean = 3.5, sd = 0.5 }, lapse = 0.02 }
`);
  const { base, ended } = await run("1", { protocol: join(here, "seated.toml"), folder: seated });
  const { page, close } = await open(base, { touch: false });
  const other = await open(`${base}experimenter`, { touch: false });
  await on(page, "begin");
  await page.keyboard.press(" ");
  let seed = 7;
  const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
  let asked = 0, shown = "";
  for (;;) {
    shown = await (await page.waitForFunction(() => ["interval", "done"].includes(globalThis.shown) && globalThis.shown)).jsonValue();
    if (shown === "done") break;
    // Both pages are told by themselves: the experimenter's may still show the trial before.
    const words = await other.page.waitForFunction(done => globalThis.view?.done === done && view.trial, asked);
    const [, intervals] = /: (.*)$/.exec(await words.jsonValue());
    const right = /^nothing/.test(intervals) ? 2 : 1, level = Number(/at (\S+) dB/.exec(intervals)[1]);
    const feels = 1 - 0.02 - 0.48 * Math.exp(-(10 ** ((3.5 * (level - truth)) / 20)));
    await page.keyboard.press(String(random() < feels ? right : 3 - right));
    await page.waitForFunction(() => globalThis.shown !== "interval");
    asked += 1;
  }
  await close();
  await other.close();
  assert.equal((await ended).code, 0);
  assert.equal(asked, 20);
  const found = JSON.parse(execFileSync(hil, ["study", "analyse", seated, "--json"], { encoding: "utf8" }));
  const { value, low, high } = found.participants[0].thresholds[0].estimate;
  assert(low <= truth && truth <= high && high - low < 14, `${value} dB [${low}, ${high}] of ${truth} dB`);
  console.log(`study: a simulated person on the page ok; ${truth} dB came back as ${value.toFixed(1)} dB [${low.toFixed(1)}, ${high.toFixed(1)}]`);
}

const analysis = JSON.parse(execFileSync(hil, ["study", "analyse", out, "--json"], { encoding: "utf8" }));
assert.equal(analysis.participants.length, 3);
assert.equal(analysis.simulated, false);
assert.deepEqual(analysis.participants.map(p => p.complete), [true, true, false]);
assert.equal(analysis.participants[0].drawings.length, 2);
// The pen drew from below to above through the middle, as the first stroke of the scene goes.
assert(analysis.participants[0].drawings[0].error.breaks === 0 && analysis.participants[0].drawings[1].error.breaks === 1);
assert.deepEqual(analysis.ratings.map(r => r.values), [[2, 3], [5, 6]]);
const report = join(out, "analysis", "index.html");
assert(existsSync(report));
for (const scheme of ["light", "dark"]) {
  const { page, close } = await open(`file://${report}`, { width: 1280, height: 900, scheme, touch: false });
  await accessible(page, `study report ${scheme}`);
  if (pictures) await page.screenshot({ path: join(pictures, `study-report-${scheme}.png`), fullPage: true });
  await close();
}
console.log("study: analysis ok");
await browser.close();
