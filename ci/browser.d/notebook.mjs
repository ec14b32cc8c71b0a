// The page of a notebook in Chromium, over a loop in a Python process: a front end as anywidget has it.
//
//   notebook.mjs PYTHON FRONT [PICTURES]      # FRONT: hil/python/tests/front.py
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { join } from "node:path";
import { createInterface } from "node:readline";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [python, front, pictures] = process.argv.slice(2);
const kernel = spawn(python, [front], { stdio: ["pipe", "pipe", "inherit"] });
const lines = createInterface({ input: kernel.stdout });
const first = new Promise(done => lines.once("line", done));
const { esm, text } = JSON.parse(await first);

const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1100, height: 1300 } }), wrong = [];
page.on("console", message => ["error", "warning"].includes(message.type()) && wrong.push(message.text()));
page.on("pageerror", error => wrong.push(error.message));
page.on("request", request => /^(data|blob|about):/.test(request.url()) || wrong.push(request.url()));
await page.exposeFunction("toKernel", message => kernel.stdin.write(`${JSON.stringify(message)}\n`));
lines.on("line", line => page.evaluate(message => globalThis.fromKernel(message), JSON.parse(line)).catch(() => {}));
await page.setContent("<main id='el'></main>");
await page.evaluate(async ([esm, text]) => {
  const { default: widget } = await import(`data:text/javascript,${encodeURIComponent(esm)}`), heard = new Set();
  globalThis.fromKernel = message => heard.forEach(hear => hear(message));
  const model = { get: name => ({ _text: text })[name], send: toKernel, on: (_, hear) => heard.add(hear), off: (_, hear) => heard.delete(hear) };
  globalThis.gone = widget.render({ model, el: document.getElementById("el") });
}, [esm, text]);

const frame = await (await page.waitForSelector("iframe")).contentFrame();
const pass = async us => { const until = await frame.evaluate(() => palpate.now) + us; await frame.waitForFunction(t => palpate.now >= t, until, { timeout: 60000 }); };
await frame.waitForFunction(() => globalThis.palpate?.picture, null, { timeout: 60000 });
assert.equal(await frame.evaluate(() => getComputedStyle(document.getElementById("choices")).display), "none");
const height = await frame.evaluate(() => document.documentElement.offsetHeight);
await page.waitForFunction(height => Math.abs(document.querySelector("iframe").offsetHeight - height) < 2, height);

// A drag is felt where it ends.
const box = await frame.locator("#pad-canvas").boundingBox(), at = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
await page.mouse.move(at.x, at.y);
await page.mouse.down();
for (let n = 1; n <= 10; n++) { await page.mouse.move(at.x + 4 * n, at.y - 2 * n); await pass(20000); }
await pass(1.5e6);
const { felt, contacts, finger, bursts } = await frame.evaluate(() => ({ felt: palpate.finger.felt, contacts: palpate.picture.contacts, finger: [...palpate.pad.fingers.values()][0], bursts: document.getElementById("felt-place").textContent }));
const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
assert(contacts.length === 1 && apart(contacts[0].at_mm, [finger.x, finger.y]) < 1, JSON.stringify([contacts, finger]));
assert(felt?.level_db >= 0 && apart(felt.at_mm, felt.target_mm) < 1.5, `${JSON.stringify(felt)} ${bursts}`);
if (pictures) await page.screenshot({ path: join(pictures, "notebook.png"), fullPage: true });
await page.mouse.up();

// It pauses, goes one period further, and goes on.
await frame.click("#pause");
await frame.waitForFunction(() => !palpate.asked);
const stood = await frame.evaluate(() => palpate.now);
await frame.click("#period");
await frame.waitForFunction(t => palpate.now > t, stood);
assert.equal(await frame.evaluate(() => palpate.now - Math.floor(palpate.head.period_ns / 1000)), stood, "one period");
await frame.click("#pause");
await pass(300000);
assert.equal(await frame.evaluate(() => palpate.picture.contacts.length), 0);

// A view that is closed says nothing more.
await page.evaluate(() => gone());
assert.equal(await page.locator("iframe").count(), 0);
assert.deepEqual(wrong, []);
await browser.close();
kernel.stdin.end();
console.log("notebook: touch, step, picture ok");
