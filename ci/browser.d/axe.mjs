// What axe-core finds wrong with a page: nothing, in none of its frames, that is more than minor.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const require = createRequire(join(process.env.PALPATE_DRIVER, "package.json"));
const source = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

export async function accessible(page, where) {
  const found = [];
  for (const frame of page.frames()) {
    await frame.evaluate(source);
    const { violations, passes } = await frame.evaluate(() => axe.run(document, { iframes: false, resultTypes: ["violations"] }));
    assert(passes.length > 10, `${where}: axe looked at ${passes.length} rules only`);
    for (const { id, impact, nodes } of violations) {
      const places = nodes.slice(0, 4).map(node => `${node.target.join(" ")}: ${node.any[0]?.message ?? node.failureSummary.split("\n")[1]}`);
      if (["moderate", "serious", "critical"].includes(impact)) found.push(`${id} (${impact})\n  ${places.join("\n  ")}`);
    }
  }
  assert.deepEqual(found, [], `${where}\n${found.join("\n")}`);
}
