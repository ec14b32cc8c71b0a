// The page: opens a session, lets it go on picture by picture, and shows it.
import { number } from "palpate/draw.js";
import { Finger } from "palpate/finger.js";
import { Loop } from "palpate/palpate.js";
import { Pad } from "palpate/pad.js";
import { Panels } from "palpate/panels.js";
import { Plots, span } from "palpate/plots.js";
import { Settings } from "palpate/settings.js";
import { command, file, link, unfile, unlink } from "palpate/share.js";
import { Tour } from "palpate/tour.js";

const by = id => document.getElementById(id);
const say = text => { by("alert").textContent = text; by("alert").hidden = !text; };
const speak = text => { by("spoken").textContent = text; };
// A picture is of so much time at most, so that a page that was hidden does not jump, us.
const MOST_US = 50000;
// A session is repeated for so long at a time, ms.
const REPEAT_MS = 20;
// What the pulses show at full speed, us; slower, so much less.
const SPAN_US = 3e6;

class Page {
  constructor(loop, shelves) {
    Object.assign(this, { loop, now: 0, paused: false, last: null, failed: false });
    this.pad = new Pad(by("pad"), by("pad-canvas"), by("force"), by("size"));
    this.finger = new Finger(by("flat"), by("solid"));
    this.plots = new Plots(by("pulses"), by("warm"), by("warm-high"), by("warm-low"));
    this.panels = new Panels();
    this.settings = new Settings(by("settings"), shelves, () => this.begin());
    this.tour = new Tour(by("tour"));
    this.listen();
  }

  listen() {
    by("pause").addEventListener("click", () => this.pause(!this.paused));
    by("period").addEventListener("click", () => this.period());
    by("again").addEventListener("click", () => this.begin());
    by("share").addEventListener("click", () => this.share().catch(error => say(error.message)));
    by("copy").addEventListener("click", () => this.copy());
    by("save").addEventListener("click", () => this.save());
    by("open").addEventListener("change", event => this.openFile(event.target.files[0]));
    document.querySelector("[data-close]").addEventListener("click", () => by("share-dialog").close());
    for (const button of document.querySelectorAll("[data-path]")) button.addEventListener("click", () => {
      const { bench, set, observe } = this.settings.chosen();
      this.settings.choose({ scene: button.dataset.path, bench, set, observe });
      this.begin();
    });
    addEventListener("hashchange", () => this.arrive());
    addEventListener("keydown", event => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input,select,dialog")) return;
      if (event.key === "p") this.pause(!this.paused);
      if (event.key === ".") this.period();
    });
    for (const id of ["force", "size"]) by(id).addEventListener("input", () => this.sliders());
    this.sliders();
  }

  sliders() {
    by("force-out").textContent = `${number(+by("force").value, 2)} N`;
    by("size-out").textContent = `${number(+by("size").value, 1)} mm`;
  }

  // The session that a link says, or a fresh one.
  async arrive() {
    let told = "";
    if (location.hash) {
      try {
        this.settings.choose({ scene: "", ...(await unlink(location.hash)) });
      } catch (error) {
        told = error.message;
        if (error.session) this.settings.chooseNearest(error.session);
      }
    }
    await this.begin(told);
  }

  // Begins a session. The reference is taken at once, before anybody can touch.
  async begin(told = "") {
    try {
      if (this.settings.wantsModel()) await this.fetchModel();
      const head = this.loop.ask({ do: "open", ...this.settings.chosen() });
      Object.assign(this, { head, now: 0, failed: false, picture: null });
      for (const part of [this.pad, this.finger, this.plots, this.panels]) part.open(head);
      by("observed").hidden = !head.observed;
      by("described").textContent = head.description;
      by("summary").textContent = [head.scene, head.skin, head.bench, head.display, head.wire, head.illusion, head.renderer, head.person].join(" \u00b7 ");
      for (const button of document.querySelectorAll("[data-path]")) button.setAttribute("aria-pressed", button.dataset.path === head.scene);
      this.step(head.quiet_us + 20000);
      say(told);
    } catch (error) {
      this.failed = true;
      say(told ? `${told} ${error.message}` : error.message);
    }
  }

  async fetchModel() {
    if (this.modelled) return;
    speak("fetching the texture model");
    const answer = await fetch("model.safetensors").catch(() => null);
    if (!answer?.ok) throw new Error("This scene has a texture, whose model lies in a file beside the page (model.safetensors), and that could not be fetched. Serve the folder, or choose another scene.");
    this.loop.model(new Uint8Array(await answer.arrayBuffer()));
    this.modelled = true;
  }

  pause(paused) {
    this.paused = paused;
    by("pause").setAttribute("aria-pressed", paused);
    by("pause").textContent = paused ? "Go on" : "Pause";
  }

  period() {
    this.pause(true);
    if (!this.failed && this.head) this.step(this.now + this.head.period_ns / 1000);
  }

  // Lets the session go on until `until` and takes in what happened.
  step(until) {
    try {
      const began = performance.now(), fingers = this.pad.take();
      const picture = this.loop.ask({ do: "step", until_us: Math.round(until), fingers });
      Object.assign(this, { now: picture.now_us, picture, took: performance.now() - began });
      for (const part of [this.finger, this.plots, this.panels]) part.take(picture);
    } catch (error) {
      this.failed = true;
      say(`${error.message}. Begin anew to go on.`);
    }
  }

  // One picture of the screen.
  frame(at) {
    const passed = Math.min((at - (this.last ?? at)) * 1000, MOST_US), speed = +by("speed").value;
    this.last = at;
    if (this.head && !this.failed) {
      // Fractions of a microsecond wait: time goes on in whole ones.
      this.due = (this.due ?? 0) + passed * speed;
      const whole = Math.floor(this.due);
      this.due -= whole;
      if (!this.paused && whole > 0) this.step(this.now + whole);
      if (this.picture) this.draw(speed);
    }
    requestAnimationFrame(next => this.frame(next));
  }

  draw(speed) {
    const began = performance.now();
    const wide = Math.max(SPAN_US * speed ** 0.5, 5000), slow = this.paused && speed === 1 ? 120000 : wide;
    this.pad.draw(this.picture);
    this.finger.draw(this.picture);
    this.plots.draw(this.picture, slow);
    const clock = `${number(this.now / 1e6, speed < 1 || this.paused ? 4 : 3)} s`;
    if (by("clock").textContent !== clock) by("clock").textContent = clock;
    if (by("pulses-from").textContent !== span(slow)) by("pulses-from").textContent = span(slow);
    this.drew = performance.now() - began;
  }

  async share() {
    this.pause(true);
    const saved = this.loop.ask({ do: "save" }), { bench, set, observe, seed } = this.settings.chosen();
    this.shared = { text: saved.text, bench, set: set.filter(each => each.startsWith("bench.")), observe, seed };
    const url = await link(this.shared);
    by("share-link").value = url ?? "too long for a link: save it as a scene";
    by("copy").disabled = !url;
    by("command").textContent = command(this.shared, "touched.toml");
    by("share-what").textContent = `${number(saved.length_s, 1)} s of touching.`;
    by("share-dialog").showModal();
    by("share-link").select();
    await this.repeat(saved.length_s);
  }

  // What a run of the shared session comes to: run beside this one, a piece at a time, while the dialogue is open.
  async repeat(length_s) {
    const { shared } = this, end = Math.round(length_s * 1e6), lasts = `${number(length_s, 1)} s of touching.`;
    const twin = await this.loop.twin();
    twin.ask({ do: "open", ...shared });
    for (let now = 0; now < end;) {
      const pause = performance.now() + REPEAT_MS;
      for (; now < end && performance.now() < pause; now = Math.min(now + MOST_US, end)) twin.ask({ do: "step", until_us: Math.min(now + MOST_US, end) });
      by("share-what").textContent = `${lasts} Repeating it for the digest of its schedule: ${Math.floor(100 * now / end)} %.`;
      await new Promise(done => setTimeout(done));
      if (!by("share-dialog").open || this.shared !== shared) return;
    }
    by("share-what").textContent = `${lasts} Its schedule has the digest ${twin.ask({ do: "end" }).digest}, here and anywhere.`;
  }

  async copy() {
    try {
      await navigator.clipboard.writeText(by("share-link").value);
      speak("copied");
      by("copy").textContent = "Copied";
    } catch {
      by("share-link").select();
      by("copy").textContent = "Press Ctrl+C";
    }
    setTimeout(() => { by("copy").textContent = "Copy link"; }, 1500);
  }

  save() {
    const url = URL.createObjectURL(new Blob([file(this.shared, "touched.toml")], { type: "application/toml" }));
    Object.assign(document.createElement("a"), { href: url, download: "touched.toml" }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }

  async openFile(chosen) {
    if (!chosen) return;
    this.settings.choose({ scene: "", ...unfile(await chosen.text()) });
    by("share-dialog").close();
    by("open").value = "";
    this.pause(false);
    await this.begin();
  }
}

async function bytes() {
  const inside = document.getElementById("module");
  if (inside) return Uint8Array.from(atob(inside.textContent.trim()), c => c.charCodeAt(0));
  const answer = await fetch("palpate.wasm");
  if (!answer.ok) throw new Error(`palpate.wasm: expected the module beside this page, found ${answer.status}`);
  return new Uint8Array(await answer.arrayBuffer());
}

try {
  if (typeof WebAssembly === "undefined") throw new Error("This browser has no WebAssembly, in which the bench runs.");
  const loop = await Loop.load(await bytes());
  const page = new Page(loop, loop.ask({ do: "shelves" }));
  // For tests and the curious.
  globalThis.palpate = page;
  await page.arrive();
  page.first = performance.now();
  page.frame(page.first);
} catch (error) {
  const old = error instanceof WebAssembly.CompileError;
  say(old ? `This browser cannot run the module (${error.message}); it needs WebAssembly as browsers have it since 2020.` : error.message);
}
