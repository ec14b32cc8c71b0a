// The page in a notebook, over a loop in Python: touches go there, one step at a time, and pictures come back.
import { number } from "palpate/draw.js";
import { Finger } from "palpate/finger.js";
import { Pad } from "palpate/pad.js";
import { Panels } from "palpate/panels.js";
import { Plots, span } from "palpate/plots.js";

const by = id => document.getElementById(id);
const put = (id, text) => { const element = by(id); if (element.textContent !== text) element.textContent = text; };
// A step is of so much time at most: a kernel that did something else does not jump, us.
const MOST_US = 50000;
// What the pulses show at full speed, us; slower, so much less.
const SPAN_US = 3e6;

class Page {
  constructor() {
    Object.assign(this, { head: null, picture: null, asked: false, paused: false, last: null, due: 0, count: 0 });
    this.id = crypto.getRandomValues(new Uint32Array(1))[0];
    this.pad = new Pad(by("pad"), by("pad-canvas"), by("force"), by("size"));
    this.finger = new Finger(by("flat"), by("solid"));
    this.plots = new Plots(by("pulses"), by("warm"), by("warm-high"), by("warm-low"));
    this.panels = new Panels();
    by("pause").addEventListener("click", () => this.pause(!this.paused));
    by("period").addEventListener("click", () => { this.pause(true); this.due = this.head.period_ns / 1000; });
    for (const id of ["force", "size"]) by(id).addEventListener("input", () => this.sliders());
    this.sliders();
    // A link opens beside the notebook, not inside its frame.
    for (const link of document.links) link.target = "_blank";
    addEventListener("message", event => event.source === parent && this.hear(event.data));
    addEventListener("sized", () => this.draw());
    new ResizeObserver(() => parent.postMessage({ height: document.documentElement.offsetHeight }, "*")).observe(document.body);
    put("run", "waiting for the kernel");
    this.say({ hello: this.id });
    requestAnimationFrame(at => this.frame(at));
  }

  say(message) {
    parent.postMessage({ say: message }, "*");
  }

  sliders() {
    put("force-out", `${number(+by("force").value, 2)} N`);
    put("size-out", `${number(+by("size").value, 1)} mm`);
  }

  pause(paused) {
    this.paused = paused;
    by("pause").setAttribute("aria-pressed", paused);
    put("pause", paused ? "Go on" : "Pause");
  }

  hear({ head, touched, now_us, picture, to, failed }) {
    if (head) this.open(head, touched, now_us);
    // A picture that another page of the same loop asked for is shown here, too.
    if (to === this.id) this.asked = false;
    if (picture) this.take(JSON.parse(picture));
    if (failed) this.end(failed);
  }

  open(head, touched, now_us) {
    Object.assign(this, { head, touched, now: now_us, picture: null, asked: false, over: false });
    document.body.classList.toggle("shown", !touched);
    for (const part of [this.pad, this.finger, this.plots, this.panels]) part.open(head);
    by("observed").hidden = !head.observed;
    put("run", [head.skin, `bench ${head.bench}`, `seed ${head.seed}`, head.display, head.wire, head.illusion, head.person].join(" \u00b7 "));
    put("line", touched ? "" : "readings come from the notebook");
  }

  // Asks for the picture after so much time, us.
  step(us) {
    if (!this.head || this.asked || this.over) return;
    this.asked = true;
    this.say({ from: this.id, us: Math.round(us), fingers: this.pad.take() });
  }

  take(picture) {
    Object.assign(this, { picture, now: picture.now_us, count: this.count + 1 });
    for (const part of [this.finger, this.plots, this.panels]) part.take(picture);
    this.draw();
  }

  // One picture of the screen: the time that passed, but for what waits for the kernel, goes on in the loop.
  frame(at) {
    const passed = Math.min((at - (this.last ?? at)) * 1000, MOST_US), speed = +by("speed").value;
    this.last = at;
    if (this.touched && !this.paused && !this.over) this.due = Math.min(this.due + passed * speed, MOST_US);
    if (this.due >= 1 && !this.asked && this.head) {
      // While the reference is taken nothing may touch: it is taken at once.
      const quiet = this.head.quiet_us + 20000 - this.now, whole = Math.floor(this.due);
      this.due -= whole;
      this.step(Math.max(whole, quiet));
    }
    requestAnimationFrame(next => this.frame(next));
  }

  draw() {
    if (!this.picture) return;
    const speed = this.touched ? +by("speed").value : 1;
    const wide = Math.max(SPAN_US * speed ** 0.5, 5000), slow = this.paused && speed === 1 ? 120000 : wide;
    this.pad.draw(this.picture);
    this.finger.draw(this.picture);
    this.plots.draw(this.picture, slow);
    put("clock", `${number(this.picture.now_us / 1e6, speed < 1 || this.paused ? 4 : 3)} s`);
    put("pulses-from", span(slow));
  }

  end(sentence) {
    this.over = true;
    put("alert", sentence);
    by("alert").hidden = false;
  }
}

// For tests and the curious.
globalThis.palpate = new Page();
