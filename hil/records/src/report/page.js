// What makes a report answer: values under the pointer, one cursor and one interval for all plots against time, and
// playback. Values are read off the pictures; the block `run` has what no picture tells. Times are tenths of a
// millisecond throughout.
"use strict";
(() => {
const SECOND = 1e4, LEAST = 50;
const run = JSON.parse(document.getElementById("run").textContent);
const all = (what, where = document) => [...where.querySelectorAll(what)];
const make = (tag, about, where) => where.appendChild(Object.assign(document.createElement(tag), about));
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
let view = [0, run.end], now = null, timer = null;
document.documentElement.classList.add("live");

// The vertices of a path, stroke by stroke; written by timeplot.rs in whole numbers from point to point.
function strokes(d) {
  const found = [];
  let x = 0, y = 0;
  for (const [, letter, rest] of d.matchAll(/([a-z])([^a-z]*)/g)) {
    const n = (rest.match(/-?\d+/g) || []).map(Number);
    if (letter === "v") y += n[0];
    else if (letter === "h") x += n[0];
    for (let i = 0; i + 1 < n.length; i += 2) {
      x += n[i]; y += n[i + 1];
      if (letter === "m") found.push([]);
      found.at(-1).push([x, y]);
    }
    if (letter === "v" || letter === "h") found.at(-1).push([x, y]);
    if (letter === "z") [x, y] = found.at(-1)[0];
  }
  return found;
}

// The last of sorted items whose key is not above t; -1 where there is none.
function last(items, key, t) {
  let low = 0, high = items.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (key(items[middle]) <= t) low = middle + 1; else high = middle;
  }
  return low - 1;
}

class Curve {
  constructor(path, plot) {
    this.name = path.dataset.n; this.kind = path.dataset.k; this.plot = plot;
    this.color = getComputedStyle(path);
    this.strokes = strokes(path.getAttribute("d"));
    if (this.kind !== "dots") return;
    this.strokes.sort((a, b) => a[0][0] - b[0][0]);
    // Half of the usual distance of two dots.
    const gaps = this.strokes.slice(1).map((s, i) => s[0][0] - this.strokes[i][0][0]).sort((a, b) => a - b);
    this.half = (gaps[gaps.length >> 1] || 0) / 2;
  }
  // What it says at a time, in words; nothing where it has no value.
  at(t) {
    const { strokes, plot } = this, i = last(strokes, s => s[0][0], t);
    if (this.kind === "line") {
      const s = strokes[i], k = s ? last(s, p => p[0], t) : -1;
      if (k < 0 || (k === s.length - 1 && s[k][0] < t)) return;
      const [a, b] = [s[k], s[k + 1] || s[k]];
      const y = b[0] > a[0] ? a[1] + (b[1] - a[1]) * (t - a[0]) / (b[0] - a[0]) : a[1];
      return plot.words(plot.value(y));
    }
    const near = Math.max((view[1] - view[0]) / 300, this.half || 0), away = s => Math.abs(s[0][0] - t);
    if (this.kind === "bars") {
      const s = strokes[i];
      if (!s || t >= Math.max(s[2][0], s[0][0] + 1)) return;
      const part = (s[0][1] - s[1][1]) / plot.bar;
      return this.name === "taxels" ? `${Math.round(part * plot.most)}` : plot.words(part * plot.duty);
    }
    const close = [strokes[i], strokes[i + 1]].filter(s => s && away(s) <= near).sort((a, b) => away(a) - away(b));
    if (!close.length) return;
    return this.kind === "dots" ? plot.words(plot.value(close[0][0][1])) : (close[0][0][0] / SECOND).toFixed(4) + " s";
  }
}

class Plot {
  constructor(figure) {
    const { y, u, d, bar, duty, most } = figure.dataset;
    Object.assign(this, { figure, unit: u, digits: +d, bar: +bar, duty: +duty, most: +most });
    [this.low, this.high, this.log] = y.split(" ").map(Number);
    this.svg = figure.querySelector("svg");
    this.tall = this.svg.viewBox.baseVal.height;
    this.curves = all("path[data-k]", this.svg).map(path => new Curve(path, this));
    this.grid = this.svg.querySelector(".gx");
    this.numbers = figure.querySelector(".xs");
    this.cursor = make("div", { className: "cursor" }, figure);
    this.read = make("div", { className: "read" }, figure);
    this.band = make("div", { className: "band", hidden: true }, figure);
    figure.tabIndex = 0;
    figure.setAttribute("aria-keyshortcuts", "ArrowLeft ArrowRight + - 0 Space");
    listen(this);
  }
  value(y) {
    const part = 1 - y / this.tall;
    return this.log ? this.low * (this.high / this.low) ** part : this.low + part * (this.high - this.low);
  }
  words(value) { return value.toFixed(this.digits) + (this.unit ? "\u202f" + this.unit : ""); }
  time(event) {
    const box = this.svg.getBoundingClientRect();
    return clamp(view[0] + (event.clientX - box.left) / box.width * (view[1] - view[0]), 0, run.end);
  }
  // Shows the interval: the drawing by its view box, the numbers below anew.
  zoom() {
    const [from, to] = view, width = this.svg.clientWidth || 900, wanted = clamp(width / 60, 2, 10);
    this.svg.setAttribute("viewBox", `${from} 0 ${to - from} ${this.tall}`);
    const raw = (to - from) / SECOND / wanted, decade = 10 ** Math.floor(Math.log10(raw));
    const step = decade * [1, 2, 5, 10].find(n => n * decade >= raw * 0.999);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    let lines = "", text = "";
    for (let k = Math.ceil(from / SECOND / step - 1e-6); k * step <= to / SECOND + step * 1e-6; k++) {
      const t = k * step * SECOND;
      lines += `M${t} 0V${this.tall}`;
      text += `<span style="left:${(t - from) / (to - from) * 100}%">${(k * step).toFixed(digits)}</span>`;
    }
    this.grid.setAttribute("d", lines);
    this.numbers.innerHTML = text;
  }
  point() {
    const part = now === null ? -1 : (now - view[0]) / (view[1] - view[0]);
    const inside = part >= 0 && part <= 1;
    this.cursor.hidden = this.read.hidden = !inside;
    if (!inside) return;
    this.cursor.style.left = part * 100 + "%";
    this.read.classList.toggle("left", part > 0.5);
    this.read.replaceChildren();
    make("b", { textContent: seconds(now) }, this.read);
    for (const curve of this.curves) {
      const text = curve.at(now);
      if (text === undefined) continue;
      const row = make("span", {}, this.read), { stroke, fill } = curve.color;
      make("i", {}, row).style.background = curve.kind === "bars" && fill !== "none" ? fill : stroke;
      row.append(` ${curve.name} `);
      make("em", { textContent: text }, row);
    }
  }
}

const seconds = t => (t / SECOND).toFixed(4) + "\u202fs";

// Pointer, wheel, fingers and keys of a plot.
function listen(plot) {
  const { figure } = plot, fingers = new Map();
  let from = null, spread = null;
  const pinch = () => { const [a, b] = [...fingers.values()]; return Math.max(Math.abs(a.clientX - b.clientX), 8); };
  figure.addEventListener("pointerdown", e => {
    fingers.set(e.pointerId, e);
    if (fingers.size === 2) { spread = { width: pinch(), view: [...view], at: now }; from = null; }
    else if (e.pointerType === "mouse" && e.button === 0) from = e;
    moveTo(plot.time(e));
  });
  figure.addEventListener("pointermove", e => {
    if (fingers.has(e.pointerId)) fingers.set(e.pointerId, e);
    if (spread && fingers.size === 2) {
      const scale = spread.width / pinch(), [a, b] = spread.view;
      return show(spread.at - (spread.at - a) * scale, spread.at + (b - spread.at) * scale);
    }
    if (timer === null || fingers.size) moveTo(plot.time(e));
    if (!from) return;
    if (from.shiftKey) {
      const gone = plot.time(from) - plot.time(e), width = view[1] - view[0];
      const start = clamp(view[0] + gone, 0, run.end - width);
      show(start, start + width);
      return void (from = e);
    }
    const left = plot.svg.getBoundingClientRect().left, [a, b] = [from.clientX, e.clientX].sort((p, q) => p - q);
    plot.band.hidden = b - a < 5;
    Object.assign(plot.band.style, { left: a - left + "px", width: b - a + "px" });
  });
  const up = e => {
    fingers.delete(e.pointerId);
    spread = null;
    if (from && !plot.band.hidden && e.type === "pointerup") {
      const [a, b] = [plot.time(from), plot.time(e)].sort((p, q) => p - q);
      show(a, b);
    }
    from = null;
    plot.band.hidden = true;
  };
  for (const kind of ["pointerup", "pointercancel", "pointerleave"]) figure.addEventListener(kind, up);
  figure.addEventListener("dblclick", () => show(0, run.end));
  figure.addEventListener("wheel", e => {
    if (!(e.ctrlKey || e.metaKey || document.activeElement === figure)) return;
    e.preventDefault();
    zoomBy(Math.exp(clamp(e.deltaY, -100, 100) / 300), plot.time(e));
  }, { passive: false });
  figure.addEventListener("keydown", e => {
    const step = (view[1] - view[0]) / (e.shiftKey ? 10 : 100);
    const keys = {
      ArrowLeft: () => stepTo((now ?? view[0]) - step), ArrowRight: () => stepTo((now ?? view[0]) + step),
      "+": () => zoomBy(0.5), "=": () => zoomBy(0.5), "-": () => zoomBy(2), 0: () => show(0, run.end),
      Escape: () => show(0, run.end), " ": play,
    };
    if (e.ctrlKey || e.metaKey || e.altKey || !keys[e.key]) return;
    e.preventDefault();
    keys[e.key]();
    // Heard by those who cannot see it.
    spoken.textContent = plot.read.hidden ? "" : plot.read.textContent;
  });
}

// What of a list of rows is there at a time: the rows of its newest instant, unless that is too old.
const rows = (flat, width) => {
  const found = [];
  for (let i = 0, t = 0; i < flat.length; i += width) found.push([t += flat[i], ...flat.slice(i + 1, i + width)]);
  return found;
};
const contacts = rows(run.contacts, 6), felt = rows(run.felt, 6);
function newest(list, t, hold) {
  let i = last(list, row => row[0], t);
  const found = [];
  for (const first = list[i]?.[0]; i >= 0 && first >= t - hold && list[i][0] === first; i--) found.push(list[i]);
  return found;
}
const frames = (run.taxels.v || "").split(".");
const times = rows(run.taxels.t || [], 1);
// The taxels at a time, counts.
function taxels(t) {
  const i = last(times, row => row[0], t), values = [];
  for (const [, zeros, letter] of i < 0 ? [] : frames[i].matchAll(/(\d+)|(.)/g)) {
    if (zeros) for (let n = 0; n < +zeros; n++) values.push(0);
    else values.push((letter === "!" ? 27 : letter.charCodeAt(0) - 65) / run.taxels.levels);
  }
  return values;
}

// A picture of the skin and one of the display that follow the cursor.
class Stage {
  constructor(svg, [kx, x, ky, y]) {
    Object.assign(this, { svg, px: um => kx * um / 1e3 + x, py: um => ky * um / 1e3 + y });
    this.taxels = all(".taxel", svg);
    this.wires = all(".wire", svg);
    this.over = document.createElementNS(svg.namespaceURI, "g");
    this.over.setAttribute("class", "over");
    svg.append(this.over);
  }
  dot(x, y, kind) {
    const dot = document.createElementNS(this.svg.namespaceURI, "circle");
    for (const [k, v] of Object.entries({ class: kind, cx: this.px(x), cy: this.py(y), r: 9 })) dot.setAttribute(k, v);
    this.over.append(dot);
  }
  draw(scene) {
    this.over.replaceChildren();
    this.taxels.forEach((rect, i) => rect.style.setProperty("--v", scene.taxels[i] || 0));
    this.wires.forEach((wire, i) => wire.style.setProperty("--v", scene.wires[i] || 0));
    if (this.taxels.length) for (const [, , , x, y] of scene.contacts) this.dot(x, y, "contact-now");
    if (this.wires.length) for (const [, x, y, is, u, v] of scene.felt) {
      this.dot(x, y, "aim-now");
      if (is) this.dot(u, v, "felt-now");
    }
  }
}

// A plane: its picture, and the nearest contact or felt place under the pointer.
class Plane {
  constructor(id, list, told, pixels) {
    const box = document.getElementById(id);
    Object.assign(this, { box, list, told, stage: new Stage(box.querySelector("svg"), pixels) });
    this.read = make("div", { className: "read", hidden: true }, box);
    box.addEventListener("pointermove", e => this.hover(e));
    box.addEventListener("pointerdown", e => this.hover(e));
  }
  hover(event) {
    const { svg } = this.stage, at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    let best = 400, found = null;
    for (const row of this.list) {
      const [x, y] = this.told.place(row), d = (this.stage.px(x) - at.x) ** 2 + (this.stage.py(y) - at.y) ** 2;
      if (d < best) [best, found] = [d, row];
    }
    const box = this.stage.taxels.findIndex(rect => rect === event.target);
    this.taxel = box < 0 ? null : box;
    if (timer === null) moveTo(found ? found[0] : now ?? 0);
  }
  draw(scene) {
    this.stage.draw(scene);
    const found = scene[this.told.of];
    this.read.hidden = now === null;
    this.read.replaceChildren();
    make("b", { textContent: now === null ? "" : seconds(now) }, this.read);
    for (const row of found.slice(0, 4)) make("span", { textContent: this.told.words(row) }, this.read);
    if (found.length > 4) make("span", { textContent: `and ${found.length - 4} more` }, this.read);
    if (this.taxel != null && run.taxels.most) {
      const counts = Math.round((scene.taxels[this.taxel] || 0) * run.taxels.most);
      make("span", { textContent: `taxel ${this.taxel}: about ${counts} counts` }, this.read);
    }
    if (!found.length) make("span", { textContent: this.told.nothing }, this.read);
  }
}
const modules = new Set(contacts.map(r => r[1])).size;
const mm = um => (um / 1e3).toFixed(2).replace("-", "\u2212");
const planes = [
  new Plane("pad", contacts, {
    of: "contacts", place: r => [r[3], r[4]], nothing: "no contact",
    words: r => `${modules > 1 ? `module ${r[1]}, ` : ""}contact ${r[2]}: x ${mm(r[3])}, y ${mm(r[4])} mm, ${r[5]} counts`,
  }, run.pad),
  new Plane("display", felt, {
    of: "felt", place: r => r[3] ? [r[4], r[5]] : [r[1], r[2]], nothing: "nothing projected",
    words: r => r[3] ? `felt: x ${mm(r[4])}, y ${mm(r[5])} mm` : `break at x ${mm(r[1])}, y ${mm(r[2])} mm`,
  }, run.display),
];

// The player: both pictures small, without paths, and the controls.
const player = document.createElement("section");
player.className = "player";
player.setAttribute("aria-label", "Playback and zoom");
document.querySelector(".result").after(player);
const pictures = make("div", { className: "pictures" }, player);
const stages = planes.map(({ box, stage }) => {
  const svg = stage.svg.cloneNode(true), { x, y, width, height } = svg.querySelector(".frame");
  all(".trail,.dots,.truth,.truth-dots,.aim,.cross,.start,.grid,.over,text:not(.wire-name)", svg).forEach(e => e.remove());
  svg.setAttribute("viewBox", [x, y, width, height].map(v => v.baseVal.value).join(" "));
  pictures.append(svg);
  return new Stage(svg, run[box.id]);
});
const controls = make("div", { className: "controls" }, player);
const button = (text, label, act) => {
  const made = make("button", { type: "button", textContent: text, onclick: act, title: label }, controls);
  made.setAttribute("aria-label", label);
  return made;
};
const playing = button("\u25b6", "Play", () => play());
const speed = make("select", { title: "Speed" }, controls);
speed.setAttribute("aria-label", "Speed");
for (const s of [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10]) make("option", { value: s, textContent: s + "\u00d7", selected: s === 1 }, speed);
const scrub = make("input", { type: "range", min: 0, max: run.end, step: 1, value: 0, oninput: () => moveTo(+scrub.value) }, controls);
scrub.setAttribute("aria-label", "Time");
const clock = make("output", {}, controls);
button("\u2212", "Zoom out", () => zoomBy(2));
button("+", "Zoom in", () => zoomBy(0.5));
button("Whole run", "Show the whole run", () => show(0, run.end));
const shown = make("output", { className: "shown" }, controls);
make("p", { className: "sub", textContent: "In a plot: drag to zoom, shift and drag to move, double-click for all; wheel with Ctrl, or after a click; "
  + "arrows, +, \u2212, 0 and space on the keyboard." }, player);
const spoken = make("p", { className: "spoken" }, player);
spoken.setAttribute("aria-live", "polite");

const plots = all("figure.plot").filter(f => !f.closest(".still")).map(f => new Plot(f));
const wires = plots.flatMap(p => p.curves).filter(c => c.kind === "bars" && /^wire \d+$/.test(c.name));

function moveTo(t) {
  now = clamp(t, 0, run.end);
  const driven = [];
  for (const wire of wires) {
    const value = parseFloat(wire.at(now));
    if (value > 0) driven[+wire.name.slice(5)] = value / wire.plot.duty;
  }
  const scene = { taxels: taxels(now), wires: driven, contacts: newest(contacts, now, run.hold), felt: newest(felt, now, run.soa) };
  for (const each of [...planes, ...stages]) each.draw(scene);
  for (const plot of plots) plot.point();
  scrub.value = now;
  scrub.setAttribute("aria-valuetext", seconds(now));
  clock.textContent = seconds(now);
}

function show(from, to) {
  const middle = (from + to) / 2, half = clamp((to - from) / 2, LEAST / 2, run.end / 2);
  const start = clamp(middle - half, 0, run.end - 2 * half);
  view = [start, start + 2 * half];
  for (const plot of plots) { plot.zoom(); plot.point(); }
  const [a, b] = view.map(t => (t / SECOND).toFixed(view[1] - view[0] < SECOND ? 4 : 2));
  shown.textContent = `${a} to ${b} s`;
}

// As moveTo, and the interval goes along.
function stepTo(t) {
  moveTo(t);
  const beyond = Math.max(now - view[1], 0) + Math.min(now - view[0], 0);
  if (beyond) show(view[0] + beyond, view[1] + beyond);
}

function zoomBy(scale, about = now ?? (view[0] + view[1]) / 2) {
  const at = clamp(about, ...view);
  show(at - (at - view[0]) * scale, at + (view[1] - at) * scale);
}

function play() {
  const stop = timer !== null;
  if (stop) { cancelAnimationFrame(timer); timer = null; }
  else {
    if (now === null || now >= view[1] || now < view[0]) now = view[0];
    let before = performance.now();
    const tick = at => {
      moveTo(now + (at - before) * 10 * +speed.value);
      before = at;
      if (now >= view[1]) { timer = null; label(); } else timer = requestAnimationFrame(tick);
    };
    timer = requestAnimationFrame(tick);
  }
  label();
}

function label() {
  playing.textContent = timer === null ? "\u25b6" : "\u275a\u275a";
  playing.setAttribute("aria-label", timer === null ? "Play" : "Pause");
}

// Space plays wherever no control has a use of its own for it.
addEventListener("keydown", e => {
  if (e.key !== " " || e.repeat || e.defaultPrevented || e.ctrlKey || e.metaKey || e.altKey) return;
  if (e.target.closest?.("button,select,a,summary")) return;
  e.preventDefault();
  play();
});
addEventListener("resize", () => plots.forEach(p => p.zoom()));
addEventListener("beforeprint", () => show(0, run.end));
show(0, run.end);
clock.textContent = seconds(0);
})();
