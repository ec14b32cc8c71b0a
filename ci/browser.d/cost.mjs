// What the live view costs: CPU time of a served run with one page and with none, thread by thread, and its records.
//
//   cost.mjs HIL SECONDS SCENE
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [hil, seconds, scene] = process.argv.slice(2), length = +seconds, ROUNDS = 3;
const folder = mkdtempSync(join(tmpdir(), "palpate-"));
const records = ["mcap", "jsonl", "csv", "vcd"];
const args = name => ["run", scene, "--set", `length_s=${length}`, "--quiet", ...records.flatMap(ending => ["--record", join(folder, `${name}.${ending}`)])];

// On the processor so far, seconds: the loop's thread and all others. The kernel counts nanoseconds.
function cpu(pid) {
  const used = { loop: 0, others: 0 };
  for (const task of readdirSync(`/proc/${pid}/task`)) {
    const ns = +readFileSync(`/proc/${pid}/task/${task}/schedstat`, "utf8").split(" ")[0];
    used[+task === pid ? "loop" : "others"] += ns / 1e9;
  }
  return used;
}

// A page that takes every picture, and does nothing with it; or one that only lets the run begin, and goes.
function page(base, goes) {
  const { host, port, hostname } = new URL(base), seen = { bytes: 0 };
  const socket = connect(+port, hostname, () => socket.write(`GET /live HTTP/1.1\r\nHost: ${host}\r\nOrigin: http://${host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n`));
  socket.on("data", data => { seen.bytes += data.length; if (goes) socket.destroy(); });
  socket.on("error", () => {});
  return seen;
}

async function served(pages, name) {
  const run = spawn(hil, [...args(name), "--serve", "0"], { stdio: ["ignore", "ignore", "pipe"] });
  const ended = new Promise(done => run.on("exit", done));
  let told = "", used = null, seen = [];
  run.stderr.on("data", data => {
    told += data;
    const base = /(http:\S+\/)/.exec(told)?.[1];
    if (base && !seen.length) seen = [page(base, !pages)];
    if (/the page stays/.test(told)) run.kill("SIGINT");
  });
  // Of the run without what comes after it: its records are written then.
  const began = performance.now();
  while (performance.now() - began < length * 1000 - 300) {
    await new Promise(done => setTimeout(done, 100));
    try { used = { ...cpu(run.pid), at: (performance.now() - began) / 1000 }; } catch { break; }
  }
  assert.equal(await ended, 0, told);
  if (pages) assert(seen[0].bytes > 5000 * length, `a page got ${seen[0].bytes} bytes only`);
  return { loop: used.loop / used.at, others: used.others / used.at, bytes: seen[0]?.bytes ?? 0 };
}

execFileSync(hil, args("plain"));
const percent = value => `${(value * 100).toFixed(2)} %`, median = all => all.sort((a, b) => a - b)[all.length >> 1];
const none = [], one = [];
for (let round = 0; round < ROUNDS; round++) {
  none.push(await served(0, "none"));
  one.push(await served(1, "one"));
  for (const name of ["none", "one"])
    for (const ending of records) assert(readFileSync(join(folder, `plain.${ending}`)).equals(readFileSync(join(folder, `${name}.${ending}`))), `${ending}: other bytes with ${name === "one" ? "a" : "no"} page`);
}
const of = (all, key) => median(all.map(each => each[key]));
console.log(`live: of a core, while ${length} s of ${scene} keep to the wall clock (median of ${ROUNDS}):`);
console.log(`  no page   loop ${percent(of(none, "loop"))}, other threads ${percent(of(none, "others"))}`);
console.log(`  one page  loop ${percent(of(one, "loop"))}, other threads ${percent(of(one, "others"))}; ${(of(one, "bytes") / length / 1000).toFixed(0)} kB/s`);
const added = of(one, "loop") - of(none, "loop");
console.log(`  a page adds ${percent(added)} of the loop's time to the loop, ${percent(added / of(none, "loop"))} of what it computes, and ${percent(of(one, "others") - of(none, "others"))} to others`);
console.log(`  records (${records.join(", ")}): the same bytes`);
rmSync(folder, { recursive: true });
