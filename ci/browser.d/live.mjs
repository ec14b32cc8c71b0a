// The page over a run (`hil run --serve`) in Chromium: pictures, a second page, a lost connection, STOP.
//
//   live.mjs HIL [PICTURES]
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { join } from "node:path";
import { accessible } from "./axe.mjs";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [hil, pictures] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });

// A run with its page; it begins once a page is open.
async function serve(port, ...args) {
  const run = spawn(hil, ["run", ...args, "--serve", port, "--quiet"], { stdio: ["ignore", "ignore", "pipe"] });
  const ended = new Promise(done => run.on("exit", done));
  const base = await new Promise((done, failed) => {
    let told = "";
    run.stderr.on("data", data => { told += data; const found = /(http:\S+\/)/.exec(told); if (found) done(found[1]); });
    ended.then(() => failed(new Error(told)));
  });
  return { base, ended, run };
}

async function open(base, { width = 1280, height = 900, scheme = "light" } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, reducedMotion: "reduce" });
  const page = await context.newPage(), wrong = [], own = [base, base.replace("http", "ws")];
  page.on("console", message => ["error", "warning"].includes(message.type()) && wrong.push(message.text()));
  page.on("pageerror", error => wrong.push(error.message));
  page.on("request", request => own.some(url => request.url().startsWith(url)) || request.url().startsWith("data:") || wrong.push(request.url()));
  page.on("websocket", socket => socket.url().startsWith(own[1]) || wrong.push(socket.url()));
  await page.goto(base);
  await page.waitForFunction(() => globalThis.palpate?.picture);
  return { page, async close() { assert.deepEqual(wrong, [], base); await context.close(); } };
}

const seen = (page, count) => page.waitForFunction(n => palpate.count >= n, count, { timeout: 60000 });

const { base, ended } = await serve("0", "sphere-circle", "--set", "length_s=600");
for (const [width, height] of [[390, 844], [1280, 900], [3840, 2160]])
  for (const scheme of ["light", "dark"]) {
    const { page, close } = await open(base, { width, height, scheme });
    await seen(page, 45);
    assert(await page.evaluate(() => document.documentElement.scrollWidth) <= width, `${width}: wider than the screen`);
    await accessible(page, `live ${width} ${scheme}`);
    if (pictures) await page.screenshot({ path: join(pictures, `live-${width}-${scheme}.png`) });
    await close();
  }
console.log("live: everywhere ok");

const [one, two] = [await open(base), await open(base)];
await seen(one.page, 10);
await one.page.evaluate(() => palpate.link.socket.close());
await one.page.waitForFunction(() => palpate.plots.holes.length === 1, null, { timeout: 10000 });
assert.match(await one.page.textContent("#notes"), /connection lost from/);
const before = await one.page.evaluate(() => palpate.count);
await seen(one.page, before + 10);
console.log("live: reconnect ok");

// Wishes of a page are granted or refused in the run's notes.
await one.page.click("#hot-pass");
await one.page.waitForFunction(() => /hot pass: each of 8 wires is heated in turn/.test(document.getElementById("notes").textContent), null, { timeout: 10000 });
await one.page.click("#rezero");
await one.page.waitForFunction(() => /rezero: /.test(document.getElementById("notes").textContent), null, { timeout: 10000 });
console.log("live: wishes ok");

await two.page.click("#stop");
for (const { page, close } of [one, two]) {
  await page.waitForFunction(() => palpate.over, null, { timeout: 10000 });
  assert.match(await page.textContent("#over"), /STOPPED/);
  await accessible(page, "live, over");
  await close();
}
assert.equal(await ended, 0);
console.log("live: stop ok");

// A run that comes to its end stays in its page, with what was measured beside what the guard counted; a page that opens
// then sees the same. Ctrl-C ends it.
const short = await serve("0", "sphere-along", "--set", "length_s=3"), whole = await open(short.base, { width: 390, height: 844 });
await whole.page.waitForFunction(() => palpate.over, null, { timeout: 30000 });
const late = await open(short.base, { scheme: "dark" });
for (const { page, close } of [whole, late]) {
  await page.waitForFunction(() => document.getElementById("used").classList.contains("both"));
  const pulse = await page.$$eval("#used-pulse em", all => all.map(e => e.textContent));
  // No current is longer than what the guard passed; a page that came late has seen nothing of that.
  assert(page === late.page ? pulse[0] === "\u2013" : parseFloat(pulse[0]) >= parseFloat(pulse[1]), `pulse: ${pulse}`);
  const [name, guard, measured] = await page.$eval("#used-burst", row => [row.querySelector("span").textContent, ...[...row.querySelectorAll("em")].map(e => e.textContent)]);
  assert.deepEqual([name, measured], ["burst", "61 %"]);
  assert(page === late.page || parseFloat(guard) >= 61, `the guard counted ${guard}`);
  assert.match(await page.textContent("#over"), /The run is over/);
  assert(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "wider than the screen");
  await accessible(page, "live, measured");
  if (pictures) await page.screenshot({ path: join(pictures, `live-measured-${page === late.page ? 1280 : 390}.png`), fullPage: true });
  await close();
}
short.run.kill("SIGINT");
assert.equal(await short.ended, 0);
console.log("live: stays ok");

// Wire and skin of a stuck amplifier leave the model: no panel gives a number beyond it, and its chart says where it ends.
const burns = await serve("0", "stuck-amplifier"), burnt = await open(burns.base, { width: 390, height: 844, scheme: "dark" });
await burnt.page.waitForFunction(() => palpate.over, null, { timeout: 60000 });
assert.match(await burnt.page.textContent("#hottest"), /hottest skin over 100 \u00b0C of 43; dose \u03a9 > 1e6, CEM43 > 1e6 min/);
assert.match(await burnt.page.textContent("#warm-high"), /not drawn over 100 \u00b0C, where the model ends/);
const told = await burnt.page.evaluate(() => document.body.innerText.match(/\d+(\.\d+)?(?= \u00b0C)/g).map(Number));
assert(Math.max(...told) <= 400, `a page tells ${Math.max(...told)} \u00b0C`);
assert(await burnt.page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "wider than the screen");
if (pictures) await burnt.page.screenshot({ path: join(pictures, "live-burnt-390.png"), fullPage: true });
await burnt.close();
burns.run.kill("SIGINT");
await burns.ended;
console.log("live: ends of the model ok");

// With --loop another run follows in the same page.
const loop = await serve("0", "idle", "--set", "length_s=1.5", "--loop"), watching = await open(loop.base);
const first = await watching.page.evaluate(() => palpate.run);
await watching.page.waitForFunction(run => palpate.run !== run && palpate.picture?.now_us > 0 && !palpate.over, first, { timeout: 30000 });
await watching.page.click("#stop");
await watching.page.waitForFunction(() => palpate.over && /STOPPED/.test(document.getElementById("over").textContent), null, { timeout: 10000 });
assert.equal(await loop.ended, 0);
await watching.page.context().close();
console.log("live: loop ok");

// On a phone the finger stays in view while the skin is.
const phone = await serve("0", "sphere-circle", "--set", "length_s=600"), hand = await open(phone.base, { width: 390, height: 844 });
const boxes = await hand.page.evaluate(() => ["pad", "flat"].map(id => { const { top, bottom } = document.getElementById(id).getBoundingClientRect(); return [id, top, bottom]; }));
for (const [id, top, bottom] of boxes) assert(top >= 0 && bottom <= 844, `${id} is out of view: ${top} to ${bottom}`);
await hand.close();
phone.run.kill("SIGKILL");
console.log("live: phone ok");

// Pictures that did not come are counted; a run that dies leaves its last one; the next at that address is another run.
const dying = await serve("0", "sphere-circle", "--set", "length_s=600"), last = await open(dying.base);
await seen(last.page, 10);
const [missed, line] = await last.page.evaluate(() => {
  const before = palpate.missed;
  palpate.take({ number: palpate.number + 4, display: 0, picture: palpate.picture });
  return [before + 3, document.getElementById("line").textContent];
});
assert.match(line, new RegExp(`live, ${missed} pictures missed`));
dying.run.kill("SIGKILL");
await last.page.waitForFunction(() => /connection lost; trying again/.test(document.getElementById("line").textContent) && document.getElementById("stop").disabled);
const run = await last.page.evaluate(() => palpate.run), { port } = new URL(dying.base);
const next = await serve(port, "sphere-along", "--set", "length_s=600");
await last.page.waitForFunction(before => palpate.run !== before && palpate.head.scene === "sphere-along" && palpate.picture, run, { timeout: 20000 });
assert.equal(await last.page.evaluate(() => palpate.missed), 0);
await last.page.click("#stop");
await last.page.waitForFunction(() => palpate.over, null, { timeout: 10000 });
assert.equal(await next.ended, 0);
await last.page.context().close();
console.log("live: another run ok");

// A page without the token that its server wants says so, by whatever name of this computer it was opened.
const guarded = await serve("0.0.0.0:0", "idle", "--set", "length_s=600"), stranger = await browser.newPage();
await stranger.goto(guarded.base.replace("0.0.0.0", "127.0.0.1"));
await stranger.waitForFunction(() => /no connection: open the address with the token/.test(document.getElementById("line").textContent), null, { timeout: 10000 });
guarded.run.kill("SIGKILL");
console.log("live: token ok");
await browser.close();
