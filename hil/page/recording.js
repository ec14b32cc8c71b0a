// The page over a recording: any moment of it, at any speed; two of them stand beside each other over one clock.
import { number } from "palpate/draw.js";
import { Finger } from "palpate/finger.js";
import { Link, unlinked } from "palpate/link.js";
import { Pad } from "palpate/pad.js";
import { Panels } from "palpate/panels.js";
import { Plots, span } from "palpate/plots.js";

const by = id => document.getElementById(id);
const put = (id, text) => { const element = by(id); if (element.textContent !== text) element.textContent = text; };
// What the pulses show at full speed, us; slower, so much less.
const SPAN_US = 3e6;
// Least time between two numbers; a step of the arrow keys, and with Shift.
const NUMBERS_MS = 100, STEP_US = 100000, LEAP_US = 1e6;
// Which of the recordings this page shows; a page of its own for each where there are two.
const shown = new URLSearchParams(location.search).get("run");

// One recording: asks for the moment that is wanted, one at a time, and shows what comes.
class Recording {
  constructor(number, ready) {
    Object.assign(this, { number, ready, wanted: 0, span: SPAN_US, asked: false, run: null, count: 0 });
    this.pad = new Pad(by("pad"), by("pad-canvas"), by("force"), by("size"));
    this.finger = new Finger(by("flat"), by("solid"));
    this.plots = new Plots(by("pulses"), by("warm"), by("warm-high"), by("warm-low"));
    this.panels = new Panels();
    by("pad").removeAttribute("tabindex");
    by("pad").setAttribute("role", "img");
    by("pad").setAttribute("aria-label", "The robot's skin: readings of all taxels and contacts");
    this.link = new Link(message => this.hear(message), up => this.stand(up));
    addEventListener("sized", () => this.draw());
  }

  hear(message) {
    if (message.hello) this.begin(message.hello);
    if (message.failed) { this.asked = false; this.say(message.failed); }
    if (message.moment) this.take(message.moment);
  }

  begin(hello) {
    const { recording, heads: [head] } = hello, { file } = recording.of[recording.shown];
    const lacks = recording.lacks.length ? `${file} has no ${recording.lacks.join(", no ")}${recording.lacks.includes("temperatures") && head.source === "real" ? "; a real bench measures none" : ""}.` : "";
    Object.assign(this, { run: hello.run, head, asked: false, end: hello.end_us });
    for (const part of [this.pad, this.finger, this.plots, this.panels]) part.open(head);
    by("observed").hidden = !head.observed;
    put("run", [recording.of.length > 1 && "AB"[recording.shown], file, head.scene, `bench ${head.bench}, ${head.observed ? "observed" : head.source}`, `seed ${head.seed}`, head.skin, head.display, head.wire, head.illusion, head.person].filter(Boolean).join(" \u00b7 "));
    put("lacks", [recording.damaged && `${file} is damaged: ${recording.damaged}.`, lacks].filter(Boolean).join(" "));
    by("lacks").hidden = !by("lacks").textContent;
    document.title = `${file} \u2013 Palpate`;
    this.ready(hello);
    this.show(this.wanted, this.span);
  }

  say(text) {
    put("alert", text);
    by("alert").hidden = !text;
  }

  stand(up) {
    if (this.link?.closed) return;
    this.asked = false;
    if (up) this.link.send({ run: this.number });
    by("line").classList.toggle("lost", !up);
    put("line", up ? "" : unlinked(this.run));
  }

  // The moment that is wanted next; of several while one is on its way, the last.
  show(at, span) {
    [this.wanted, this.span] = [Math.round(at), span];
    if (!this.head || this.asked || (this.picture && this.shows === this.wanted)) { this.draw(); return; }
    this.asked = this.link.send({ at_us: this.wanted });
    this.awaited = this.wanted;
  }

  take({ picture, past, totals }) {
    this.asked = false;
    this.panels.sofar = totals;
    if (past) {
      for (const part of [this.finger, this.plots, this.panels]) part.open(this.head);
      this.plots.begin(past);
    }
    Object.assign(this, { picture, shows: this.awaited, count: this.count + 1 });
    this.say("");
    for (const part of [this.finger, this.plots]) part.take(picture);
    this.panels.happened(picture);
    this.numbers();
    this.show(this.wanted, this.span);
    this.draw();
  }

  // Numbers of the newest picture, some times per second: what changes with every picture cannot be read.
  numbers() {
    this.due ??= setTimeout(() => { this.due = null; this.panels.numbers(this.picture); this.counted = performance.now(); }, Math.max(0, NUMBERS_MS - (performance.now() - (this.counted ?? 0))));
  }

  draw() {
    if (!this.picture || this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      this.pad.draw(this.picture);
      this.finger.draw(this.picture);
      this.plots.draw(this.picture, this.span);
      put("pulses-from", span(this.span));
    });
  }
}

// The clock: a slider, keys, a speed; what it shows follows.
class Clock {
  constructor(show) {
    Object.assign(this, { show, at: 0, end: 0, playing: false, last: null });
    by("play").addEventListener("click", () => this.play(!this.playing));
    by("speed-of").addEventListener("change", () => this.tell());
    by("time").addEventListener("input", () => this.go(+by("time").value));
    addEventListener("keydown", event => this.key(event));
    requestAnimationFrame(at => this.frame(at));
  }

  // How long the longest of them is, and the step from one PWM period to the next.
  open(end, period) {
    Object.assign(this, { end, period });
    by("time").max = end;
    by("time").step = 1000;
    put("ends", `of ${number(end / 1e6, 2)} s`);
    this.tell();
  }

  get speed() { return +by("speed-of").value; }

  // Slower than real time single pulses are looked at, and so where it stands still between two periods.
  get span() { return SPAN_US * Math.min(this.speed, 1) ** 0.6; }

  play(playing) {
    if (playing && this.at >= this.end) this.at = 0;
    this.playing = playing;
    by("play").setAttribute("aria-pressed", playing);
    put("play", playing ? "Pause" : "Play");
    this.tell();
  }

  go(at) {
    this.at = Math.min(Math.max(at, 0), this.end);
    this.tell();
  }

  tell() {
    // Whole milliseconds, so that the slider's own step rounds nothing.
    by("time").value = Math.round(this.at / 1000) * 1000;
    by("time").setAttribute("aria-valuetext", `${number(this.at / 1e6, 2)} seconds`);
    put("time-out", `${number(this.at / 1e6, this.speed < 1 ? 4 : 3)} s`);
    this.show(this.at, this.span);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input:not(#time),select,button,a,summary")) return;
    const step = event.shiftKey ? LEAP_US : STEP_US;
    const to = { ArrowLeft: this.at - step, ArrowRight: this.at + step, Home: 0, End: this.end, ",": this.at - this.period, ".": this.at + this.period }[event.key];
    if (to !== undefined) this.go(to);
    else if (event.key === " ") this.play(!this.playing);
    else return;
    event.preventDefault();
  }

  frame(at) {
    const passed = Math.min((at - (this.last ?? at)) * 1000, 250000);
    this.last = at;
    if (this.playing && this.end) {
      this.go(this.at + passed * this.speed);
      if (this.at >= this.end) this.play(false);
    }
    requestAnimationFrame(next => this.frame(next));
  }
}

// A page of its own for each of two recordings: they are as wide as there is room, one above the other where there is little.
class Pair {
  constructor(hello, clock) {
    Object.assign(this, { clock, ready: new Set() });
    document.body.classList.add("pair");
    document.title = `${hello.recording.of.map(of => of.file).join(" and ")} \u2013 Palpate`;
    put("run", hello.recording.of.map((of, i) => `${"AB"[i]}: ${of.file}`).join(" \u00b7 "));
    const end = Math.max(...hello.recording.of.map(of => of.end_us));
    this.frames = hello.recording.of.map((of, i) => {
      const frame = Object.assign(document.createElement("iframe"), { title: `Recording ${"AB"[i]}: ${of.file}`, src: `?run=${i}${location.hash}` });
      by("pair").append(frame);
      return frame;
    });
    by("pair").hidden = false;
    clock.open(end, hello.heads[0].period_ns / 1000);
  }

  show(at, span) {
    for (const frame of this.frames) frame.contentWindow?.palpate?.show(at, span);
  }

  // A frame says that it has its recording, and how high it is.
  hear(frame, height) {
    const own = this.frames.find(each => each.contentWindow === frame);
    if (own && height) own.style.height = `${height}px`;
    this.show(this.clock.at, this.clock.span);
  }
}

if (shown !== null) {
  document.body.classList.add("framed");
  const tell = () => parent.palpate?.pair?.hear(window, document.body.offsetHeight);
  globalThis.palpate = new Recording(+shown, tell);
  new ResizeObserver(tell).observe(document.body);
  // Keys are the clock's, whichever frame has the focus.
  addEventListener("keydown", event => parent.palpate?.clock.key(event));
} else {
  const page = { clock: new Clock((at, span) => (page.pair ?? page.recording)?.show(at, span)) };
  page.recording = new Recording(0, hello => {
    if (hello.recording.of.length < 2) { page.clock.open(hello.end_us, hello.heads[0].period_ns / 1000); return; }
    page.recording.link.close();
    put("line", "");
    page.pair = new Pair(hello, page.clock);
  });
  // For tests and the curious.
  globalThis.palpate = page;
}
