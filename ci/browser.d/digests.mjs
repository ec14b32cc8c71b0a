// Every built-in scene in the module, and natively: the same schedule and contacts, byte for byte.
//
//   digests.mjs SITE HIL
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [site, hil] = process.argv.slice(2).map(path => resolve(path));
const { Loop } = await import(pathToFileURL(join(site, "palpate.js")));
const loop = await Loop.load(readFileSync(join(site, "palpate.wasm")));
loop.model(readFileSync(join(site, "model.safetensors")));
const folder = mkdtempSync(join(tmpdir(), "palpate-"));
const scenes = loop.ask({ do: "shelves" }).scenes;
try {
  for (const { name: scene, bench = "emulated" } of scenes) {
    const run = loop.ask({ do: "run", scene, bench });
    const [schedule, contacts] = ["jsonl", "csv"].map(ending => join(folder, `${scene}.${ending}`));
    const native = spawnSync(hil, ["run", scene, "--bench", bench, "--quiet", "--record", schedule, "--record", contacts], { encoding: "utf8" });
    // 1: a scene that passes a limit, as `stuck-amplifier` does.
    assert([0, 1].includes(native.status), `${scene}: ${native.stderr}`);
    assert(readFileSync(schedule, "utf8") === run.lines, `${scene}: the schedule differs`);
    assert(readFileSync(contacts, "utf8") === run.table, `${scene}: the contacts differ`);
  }
} finally {
  rmSync(folder, { recursive: true });
}
console.log(`playground: ${scenes.length} scenes have the same bytes in WebAssembly as natively`);
