// Opens every report of a folder in Chromium and uses it as a person would.
//
//   reports.mjs FOLDER [PICTURES]
import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [folder, pictures] = process.argv.slice(2).map(path => path && resolve(path));
const pages = readdirSync(folder).filter(name => name.endsWith(".html")).sort();
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });

// A page that may ask nothing of anyone; what it complains about fails the check.
async function open(name, width, colorScheme, javaScriptEnabled = true) {
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme, javaScriptEnabled });
  const page = await context.newPage(), wrong = [];
  page.on("console", message => ["error", "warning"].includes(message.type()) && wrong.push(message.text()));
  page.on("pageerror", error => wrong.push(error.message));
  page.on("request", request => request.url().startsWith("file:") || wrong.push(request.url()));
  await page.goto(`file://${join(folder, name)}`);
  return { page, wrong, close: () => context.close() };
}

// What reaches beyond the page, and text that is cut.
const beyond = page => page.evaluate(() => {
  const width = document.documentElement.clientWidth, found = [];
  if (document.documentElement.scrollWidth > width) found.push(`the page is ${document.documentElement.scrollWidth} wide`);
  for (const element of document.querySelectorAll("main *:not(svg *):not(.spoken)")) {
    const box = element.getBoundingClientRect();
    if (box.width && (box.right > width + 0.5 || box.left < -0.5)) found.push(`${element.tagName} ${element.className}: ${element.textContent.slice(0, 40)}`);
  }
  for (const text of document.querySelectorAll("main svg text")) {
    const box = text.getBoundingClientRect(), frame = text.ownerSVGElement.getBoundingClientRect();
    if (text.textContent && (box.left < frame.left - 1 || box.right > frame.right + 1)) found.push(`text is cut: ${text.textContent}`);
  }
  return found.slice(0, 5);
});

// Numbers of which one half stands on another line.
const broken = page => page.evaluate(() => {
  const found = [], walk = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT), range = document.createRange();
  for (let node = walk.nextNode(); node; node = walk.nextNode())
    for (const { 0: number, index } of node.data.matchAll(/(?<![a-z])[+\u2212-]?\d[\d.]*\d/g)) {
      range.setStart(node, index);
      range.setEnd(node, index + number.length);
      if (new Set([...range.getClientRects()].filter(box => box.width).map(box => Math.round(box.top))).size > 1) found.push(number);
    }
  return found.slice(0, 5);
});

const labels = page => page.$$eval("figure.plot[tabindex] .xs", all => all.map(x => x.textContent));
const shown = page => page.$$eval("figure.plot[tabindex] > svg", all => all.map(s => s.getAttribute("viewBox").split(" ").filter((_, i) => i % 2 === 0).join(" ")));
const clock = page => page.$eval(".controls input[type=range]", range => +range.value);

async function use(name) {
  const { page, wrong, close } = await open(name, 1100, "light");
  assert.deepEqual(await beyond(page), [], `${name} at 1100`);
  const plots = await page.$$("figure.plot[tabindex]");
  assert(plots.length >= 4, `${name}: ${plots.length} plots`);

  // Values under the pointer, in every plot at once, with the unit of each.
  await plots[0].scrollIntoViewIfNeeded();
  const box = await plots[0].boundingBox();
  await page.mouse.move(box.x + box.width * 0.45, box.y + box.height / 2);
  const reads = await page.$$eval("figure.plot[tabindex] .read", all => all.map(read => [read.hidden, read.querySelector("b").textContent, read.textContent]));
  assert(reads.every(([hidden, at]) => !hidden && at === reads[0][1]), `${name}: one cursor: ${reads.map(r => r[1])}`);
  assert(reads.some(read => /\d\.\d\d\u202f\u00b0C/.test(read[2])), `${name}: no temperature`);
  const cursors = await page.$$eval("figure.plot[tabindex] .cursor", all => new Set(all.map(c => c.style.left)).size);
  assert.equal(cursors, 1, `${name}: cursors apart`);

  // Dragging zooms all of them to one interval; keys and wheel go on; a double click ends it.
  const whole = await shown(page), before = await labels(page);
  assert.equal(new Set(whole).size, 1, whole.join("; "));
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.6, box.y + box.height / 2, { steps: 4 });
  await page.mouse.up();
  const dragged = await shown(page);
  assert.equal(new Set(dragged).size, 1, dragged.join("; "));
  assert.notEqual(dragged[0], whole[0], `${name}: dragging`);
  assert((await labels(page)).every((text, i) => text !== before[i]), `${name}: numbers of the axis`);
  await plots[0].focus();
  await page.keyboard.press("+");
  const closer = await shown(page);
  assert.notEqual(closer[0], dragged[0], `${name}: the key +`);
  const at = await clock(page);
  await page.keyboard.press("ArrowRight");
  assert(await clock(page) > at, `${name}: the key to the right`);
  assert.match(await page.$eval(".spoken", p => p.textContent), /\d/);
  await page.mouse.move(box.x + box.width * 0.5, box.y + box.height / 2);
  await page.mouse.wheel(0, 120);
  assert.notEqual((await shown(page))[0], closer[0], `${name}: the wheel`);
  await page.keyboard.press("0");
  assert.deepEqual(await shown(page), whole, `${name}: the key 0`);

  // Playback goes on by itself until it is stopped, and moves what it shows.
  const scene = () => page.$eval(".pictures", p => p.innerHTML);
  await page.$eval(".controls input[type=range]", range => { range.value = range.max * 0.4; range.dispatchEvent(new Event("input")); });
  const [from, still] = [await clock(page), await scene()];
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction(from => +document.querySelector(".controls input[type=range]").value > from + 3000, from);
  await page.getByRole("button", { name: "Pause" }).click();
  // Space plays, and stops, wherever the page was touched last.
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press(" ");
  const begun = await clock(page);
  await page.waitForFunction(from => +document.querySelector(".controls input[type=range]").value > from + 1000, begun);
  await page.keyboard.press(" ");
  const paused = await clock(page);
  await page.waitForTimeout(60);
  assert.equal(await clock(page), paused, `${name}: pause`);
  const touched = await page.$$eval(".pictures .taxel", all => all.some(t => +t.style.getPropertyValue("--v") > 0));
  assert(touched || name.startsWith("idle"), `${name}: no taxel is touched`);
  assert.notEqual(await scene(), still, `${name}: the picture stands`);

  // The contact under the pointer.
  const pad = await page.$("#pad svg"), dot = await page.$("#pad .dots");
  if (dot) {
    await pad.scrollIntoViewIfNeeded();
    const place = await dot.boundingBox();
    await page.mouse.move(place.x + place.width / 2, place.y + place.height / 2);
    await page.$eval(".controls input[type=range]", range => { range.value = range.max * 0.5; range.dispatchEvent(new Event("input")); });
    assert.match(await page.$eval("#pad .read", read => read.textContent), /mm|no contact/, name);
  }
  assert.deepEqual(wrong, [], name);
  if (pictures) await page.screenshot({ path: join(pictures, `${name}-1100-light.png`), fullPage: true });
  await close();
}

async function narrow(name, scheme, scripts) {
  const { page, wrong, close } = await open(name, 390, scheme, scripts);
  const width = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert(width[0] <= width[1], `${name} at 390: ${width}`);
  assert.deepEqual(await beyond(page), [], `${name} at 390, scripts ${scripts}`);
  assert.deepEqual(await broken(page), [], `${name} at 390: numbers are broken`);
  assert.equal(await page.$$eval("figure.plot > svg path[data-k]", all => all.length > 3), true);
  // The result is the first thing, how it was made the last.
  const order = await page.$$eval(".verdict,.result,section h2", all => all.map(e => e.className.split(" ")[0] || e.textContent));
  assert(order[0] === "verdict" && (order[1] === "result" || name === "hand.html") && order.at(-1) === "How it was made", `${name}: ${order}`);
  assert.deepEqual(wrong, [], name);
  if (pictures) await page.screenshot({ path: join(pictures, `${name}-390-${scripts ? scheme : "plain"}.png`), fullPage: true });
  await close();
}

// The page of a hand: both hands drawn, and every name leads to the page of its finger.
async function hand(name) {
  const { page, wrong, close } = await open(name, 1100, "light");
  assert.deepEqual(await beyond(page), [], `${name} at 1100`);
  const links = await page.$$eval("svg a", all => all.map(a => a.getAttribute("href")));
  assert(links.length >= 8, `${name}: ${links}`);
  for (const link of links) assert(pages.includes(decodeURIComponent(link.slice(2))), `${name}: ${link}`);
  await page.click("section h2 a");
  assert.match(page.url(), /hand-\w+\.html$/);
  assert.deepEqual(wrong, [], name);
  await close();
  for (const scheme of ["dark", "light"]) await narrow(name, scheme, true);
  console.log(`  ${name}: both hands, links to fingers, 390 pixels`);
}

// Pages of sweeps, designs, trends and studies: nothing is cut or broken, and charts say their values under the pointer.
async function other(name) {
  for (const [width, scheme] of [[390, "light"], [390, "dark"], [1280, "light"]]) {
    const { page, wrong, close } = await open(name, width, scheme);
    assert.deepEqual(await beyond(page), [], `${name} at ${width}`);
    assert.deepEqual(await broken(page), [], `${name} at ${width}: numbers are broken`);
    const chart = await page.$("figure.chart[data-v]");
    if (chart) {
      await chart.scrollIntoViewIfNeeded();
      const { x, y, width: wide, height } = await chart.boundingBox(), said = () => chart.$eval(".read", read => read.hidden ? "" : read.textContent);
      await page.mouse.move(x + wide * 0.9, y + height / 2);
      assert.match(await said(), /\d/, `${name}: values under the pointer`);
      await page.mouse.move(x, y - 20);
      assert.equal(await said(), "", `${name}: the pointer is gone`);
      await chart.focus();
      await page.keyboard.press("ArrowRight");
      assert.match(await said(), /\d/, `${name}: arrow keys`);
    }
    assert.deepEqual(wrong, [], name);
    if (pictures) await page.screenshot({ path: join(pictures, `${name}-${width}-${scheme}.png`), fullPage: true });
    await close();
  }
  console.log(`  ${name}: 390 and 1280 pixels`);
}

for (const name of pages) {
  if (name.startsWith("other-")) {
    await other(name);
    continue;
  }
  // Those of its fingers are pages like any other.
  if (name.startsWith("hand-")) continue;
  if (name === "hand.html") {
    await hand(name);
    continue;
  }
  await use(name);
  await narrow(name, "dark", true);
  await narrow(name, "light", false);
  console.log(`  ${name}: values, one cursor, zoom, playback, 390 pixels, no scripts`);
}
await browser.close();
console.log(`browser: ${pages.length} reports answer`);
