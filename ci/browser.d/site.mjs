// The site in Chromium: no page is wider than a phone, the search finds, the dark is dark, axe-core finds nothing.
//
//   site.mjs SITE [PICTURES]
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { accessible } from "./axe.mjs";

const { chromium } = createRequire(join(process.env.PALPATE_DRIVER, "package.json"))("playwright-core");
const [site, pictures] = process.argv.slice(2).map(path => path && resolve(path));
const browser = await chromium.launch({ executablePath: process.env.PALPATE_CHROMIUM, args: ["--no-sandbox"] });
const pages = ["index", "start/hil-engineer", "start/haptics-lab", "howto/my-ci", "files/scene", "commands", "schemas", "hazards", "glossary", "architecture"];

let looked = 0;
for (const [width, colorScheme] of [[390, "dark"], [1280, "light"]]) {
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme });
  const page = await context.newPage(), wrong = [];
  page.on("pageerror", error => wrong.push(error.message));
  page.on("request", request => /^(file|data|blob):/.test(request.url()) || wrong.push(request.url()));
  for (const name of pages) {
    await page.goto(`file://${site}/${name}.html`);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert(wide <= 0, `${name} at ${width}: ${wide} pixels too wide`);
    const light = await page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor.match(/\d+/g).slice(0, 3).reduce((a, b) => a + +b, 0) / 3);
    assert(colorScheme === "dark" ? light < 80 : light > 200, `${name}: ${colorScheme} is ${light}`);
    await accessible(page, `${name} at ${width}, ${colorScheme}`);
    if (pictures) await page.screenshot({ path: join(pictures, `${name.replace("/", "-")}-${width}.png`) });
    looked += 1;
  }
  assert.deepEqual(wrong, [], "errors, or requests to others");
  await context.close();
}

const page = await browser.newPage();
await page.goto(`file://${site}/index.html`);
await page.click("#mdbook-search-toggle");
await page.locator("#mdbook-searchbar").pressSequentially("guardian");
await page.waitForSelector("#mdbook-searchresults li");
const found = await page.$$eval("#mdbook-searchresults li", all => all.length);
assert(found > 3, `the search finds ${found} places`);
await browser.close();
console.log(`site: ${looked} views of ${pages.length} pages, ${found} places found by the search`);
