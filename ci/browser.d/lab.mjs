// The page over a run on device nodes: the run is in the lab (tests/lab/suite/page.rs), Chromium beside it.
// `page URL` in what the lab prints says where the page is.
//
//   lab.mjs COMMAND...        # ci/lab with its arguments; PALPATE_PICTURES: where pictures of the page go
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { join } from "node:path";
import { createInterface } from "node:readline";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [command, ...words] = process.argv.slice(2), pictures = process.env.PALPATE_PICTURES;
// The lab's processor is emulated: a second of its own may last half a minute.
const PATIENCE = { timeout: 240000 };

// Looks at the run from outside, with what the address of its page has; then says STOP.
async function look(url) {
  const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });
  try {
    const page = await browser.newPage(), wrong = [];
    page.setDefaultTimeout(PATIENCE.timeout);
    page.on("console", message => ["error", "warning"].includes(message.type()) && wrong.push(message.text()));
    page.on("pageerror", error => wrong.push(error.message));
    const there = new URL(url), base = `http://127.0.0.1:${there.port}/`;
    page.on("request", request => request.url().startsWith(base) || /^(data|ws):/.test(request.url()) || wrong.push(request.url()));

    // Who has no token sees nothing of the run.
    const stranger = await browser.newPage();
    await stranger.goto(base);
    await stranger.waitForFunction(() => document.getElementById("line").classList.contains("lost"), null, PATIENCE);
    assert(await stranger.isDisabled("#stop") && await stranger.evaluate(() => !palpate.picture), "nothing without the token");
    await stranger.close();

    await page.goto(base + there.hash);
    await page.waitForFunction(() => globalThis.palpate?.count >= 5, null, PATIENCE);
    assert.match(await page.textContent("#run"), /bench lab, real/);
    await page.waitForFunction(() => palpate.picture.contacts.length === 1 && palpate.plots.bursts.some(burst => burst.ticks > 0), null, PATIENCE);
    const warm = await page.evaluate(() => palpate.picture.warm.flat().filter(Number.isFinite));
    assert.deepEqual(warm, [], "no hardware measures temperatures");
    assert.match(await page.textContent("#hottest"), /nothing measures temperatures/);
    assert(await page.evaluate(() => palpate.picture.counts.some(count => count > 0)), "readings");
    if (pictures) await page.screenshot({ path: join(pictures, "live-lab.png") });
    await page.click("#stop");
    await page.waitForFunction(() => palpate.over, null, PATIENCE);
    assert.match(await page.textContent("#over"), /STOP on a page/);
    if (pictures) await page.screenshot({ path: join(pictures, "live-lab-over.png") });
    assert.deepEqual(wrong, []);
    console.log("live: a run in the lab is shown, and stopped by its page");
  } finally {
    await browser.close();
  }
}

const lab = spawn(command, words, { stdio: ["ignore", "pipe", "inherit"], detached: true });
const ended = new Promise(done => lab.on("exit", (code, signal) => done(code ?? signal)));
// With all that it has started: the machine knows nothing of a page that failed.
const stop = () => { try { process.kill(-lab.pid); } catch { /* it has ended */ } };
for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => { stop(); process.exit(1); });
try {
  for await (const line of createInterface({ input: lab.stdout })) {
    console.log(line);
    const url = /\bpage (http:\S+)/.exec(line)?.[1];
    if (url) await look(url);
  }
  assert.equal(await ended, 0, "the lab");
} catch (error) {
  stop();
  throw error;
}
