// The page over a run: it shows what hil sends, and can say STOP.
import { number } from "palpate/draw.js";
import { Finger } from "palpate/finger.js";
import { Link, unlinked } from "palpate/link.js";
import { Pad } from "palpate/pad.js";
import { Panels } from "palpate/panels.js";
import { Plots, span } from "palpate/plots.js";

const by = id => document.getElementById(id);
const put = (id, text) => { const element = by(id); if (element.textContent !== text) element.textContent = text; };
// What the pulses show, us.
const SPAN_US = 3e6;

class Page {
  constructor() {
    Object.assign(this, { missed: 0, number: null, lost: null, display: 0, run: null, count: 0 });
    this.pad = new Pad(by("pad"), by("pad-canvas"), by("force"), by("size"));
    this.finger = new Finger(by("flat"), by("solid"));
    this.plots = new Plots(by("pulses"), by("warm"), by("warm-high"), by("warm-low"));
    this.panels = new Panels();
    by("pad").removeAttribute("tabindex");
    by("pad").setAttribute("role", "img");
    by("pad").setAttribute("aria-label", "The robot's skin: readings of all taxels and contacts");
    by("stop").addEventListener("click", () => this.stop());
    by("rezero").addEventListener("click", () => this.link.send({ rezero: true }));
    by("hot-pass").addEventListener("click", () => this.link.send({ hot_pass: true }));
    by("which-display").addEventListener("change", event => this.look(+event.target.value));
    this.link = new Link(message => this.hear(message), up => this.stand(up));
    addEventListener("sized", () => this.draw());
  }

  hear(message) {
    if (message.hello) this.begin(message.hello);
    if (message.picture) this.take(message);
    if (message.over) this.end(message.over, message.measured);
  }

  // A run, or one more of its displays; the same run again after a lost connection goes on.
  begin(hello) {
    if (hello.run === this.run && hello.heads.length === this.hello.heads.length) { if (this.display) this.link.send({ display: this.display }); return; }
    const fresh = hello.run !== this.run;
    Object.assign(this, { run: hello.run, hello });
    by("which-display").replaceChildren(...hello.names.map((name, i) => new Option(name, i)));
    by("which").hidden = hello.heads.length < 2;
    by("which-display").value = this.display;
    if (!fresh) return;
    Object.assign(this, { missed: 0, lost: null, over: false });
    by("over").hidden = true;
    this.enable(true);
    by("stop").textContent = "STOP";
    this.open(hello.heads[this.display] ?? hello.heads[0]);
  }

  open(head) {
    Object.assign(this, { head, picture: null, number: null });
    for (const part of [this.pad, this.finger, this.plots, this.panels]) part.open(head);
    by("observed").hidden = !head.observed;
    put("run", [head.scene, `bench ${head.bench}, ${head.observed ? "observed" : head.source}`, `seed ${head.seed}`, head.skin, head.display, head.wire, head.illusion, head.person].join(" \u00b7 "));
    document.title = `${head.scene} \u2013 Palpate`;
  }

  look(display) {
    this.display = display;
    this.link.send({ display });
    this.open(this.hello.heads[display]);
  }

  take({ number: n, display, picture }) {
    if (display !== this.display) return;
    if (this.lost) this.hole(picture);
    else if (this.number !== null) this.missed += n - this.number - 1;
    this.number = n;
    this.show(picture);
    this.state();
  }

  // What happens while the connection is lost is not known.
  hole(picture) {
    const from = this.picture?.now_us;
    if (from !== undefined) {
      this.plots.hole(from, picture.now_us);
      this.panels.note(picture.now_us, "off", `connection lost from ${number(from / 1e6, 2)} s to ${number(picture.now_us / 1e6, 2)} s: nothing of that is shown`);
    }
    this.lost = null;
  }

  show(picture) {
    Object.assign(this, { picture, count: this.count + 1 });
    for (const part of [this.finger, this.plots, this.panels]) part.take(picture);
    this.draw();
  }

  draw() {
    if (!this.picture || this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      this.pad.draw(this.picture);
      this.finger.draw(this.picture);
      this.plots.draw(this.picture, SPAN_US);
      put("live-clock", `${number(this.picture.now_us / 1e6, 3)} s`);
      put("pulses-from", span(SPAN_US));
    });
  }

  state() {
    if (this.over) return;
    const missed = this.missed ? `, ${this.missed} ${this.missed === 1 ? "picture" : "pictures"} missed` : "";
    const held = this.picture?.stopped ? `; outputs held off: ${this.picture.stopped}` : "";
    put("line", `live${missed}${held}`);
    by("line").classList.toggle("lost", Boolean(held));
  }

  // Whether the line is up.
  stand(up) {
    // The program has ended too: nothing more will come.
    if (this.over && !up) this.link.close();
    if (this.over) return;
    by("line").classList.toggle("lost", !up);
    put("line", up ? "connected" : unlinked(this.run));
    this.enable(up);
    if (!up && this.picture) this.lost ??= true;
  }

  stop() {
    if (!this.link.send({ stop: true })) return;
    by("stop").textContent = "Stopping";
    by("stop").disabled = true;
  }

  end(line, measured) {
    this.over = true;
    this.panels.summary(measured);
    by("over").hidden = false;
    put("over", `The run is over. ${line}`);
    put("line", "over");
    this.enable(false);
    by("stop").textContent = "STOP";
  }

  enable(on) {
    for (const id of ["stop", "rezero", "hot-pass"]) by(id).disabled = !on;
  }
}

// For tests and the curious.
globalThis.palpate = new Page();
