// The robot's skin: what is drawn of it, and the fingers that a person puts on it.
import { colors, disc, fit, mix, size, unit } from "palpate/draw.js";

const KEY_FINGER = 9;
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

export class Pad {
  constructor(element, canvas, force, size) {
    Object.assign(this, { element, canvas, force, size });
    this.fingers = new Map();
    this.changed = new Set();
    this.pointers = new Map();
    this.keys = { x: 0, y: 0 };
    this.most = 200;
    for (const [name, handle] of Object.entries({ pointerdown: this.down, pointermove: this.move, pointerup: this.up, pointercancel: this.up, keydown: this.key }))
      element.addEventListener(name, handle.bind(this));
    element.addEventListener("wheel", event => this.wheel(event), { passive: false });
    for (const slider of [force, size]) slider.addEventListener("input", () => this.resize());
  }

  // Another skin: where its taxels lie, and how much around them is shown.
  open(head) {
    this.head = head;
    this.taxels = head.modules.flatMap(m => m.taxels_mm.map(([x, y]) => [x + m.place_mm[0], y + m.place_mm[1]]));
    const rim = head.pitch_mm * 0.95, [xs, ys] = [0, 1].map(i => this.taxels.map(t => t[i]));
    const ends = all => all.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
    const [[left, right], [bottom, top]] = [ends(xs), ends(ys)];
    this.frame = { left: left - rim, right: right + rim, bottom: bottom - rim, top: top + rim };
    const module = head.modules.find(m => m.number === head.drives) || head.modules[0];
    [this.module, this.origin] = [module.number, module.place_mm];
    this.fingers.clear();
    this.changed.clear();
    this.pointers.clear();
    this.keys = { x: 0, y: 0 };
    this.most = 200;
    this.element.classList.remove("touched");
  }

  scale() {
    const { left, right, bottom, top } = this.frame, [w, h] = size(this.canvas);
    const k = Math.min(w / (right - left), h / (top - bottom));
    return { k, x: mm => w / 2 + (mm - (left + right) / 2) * k, y: mm => h / 2 - (mm - (bottom + top) / 2) * k };
  }

  // Where an event is, in the driving module's millimetres.
  place(event) {
    const box = this.canvas.getBoundingClientRect(), { k } = this.scale(), { left, right, bottom, top } = this.frame;
    const x = (event.clientX - box.left - box.width / 2) / k + (left + right) / 2;
    const y = (top + bottom) / 2 - (event.clientY - box.top - box.height / 2) / k;
    return { x: clamp(x, left, right) - this.origin[0], y: clamp(y, bottom, top) - this.origin[1] };
  }

  // A pen says how hard, and so do some screens; a mouse says one half for any click.
  strength(event) {
    const told = event.pointerType !== "mouse" && event.pressure > 0 && event.pressure < 1 && event.pressure !== 0.5;
    return told ? 2 * event.pressure : +this.force.value;
  }

  put(number, finger) {
    this.element.classList.add("touched");
    this.fingers.set(number, { ...this.fingers.get(number), ...finger });
    this.changed.add(number);
  }

  lift(number) {
    const finger = this.fingers.get(number);
    if (finger) this.put(number, { force: 0 });
  }

  free() {
    for (let number = 0; number < KEY_FINGER; number++) if (!this.fingers.get(number)?.force) return number;
    return null;
  }

  down(event) {
    if (event.button > 0) return;
    const place = this.place(event);
    const held = [...this.fingers].find(([, f]) => f.held && f.force && Math.hypot(f.x - place.x, f.y - place.y) < Math.max(f.size / 2, 1.5));
    if (held && event.shiftKey) { this.put(held[0], { held: false }); this.lift(held[0]); return; }
    const number = held ? held[0] : this.free();
    if (number === null) return;
    try { this.element.setPointerCapture(event.pointerId); } catch { /* a pointer that is gone already */ }
    this.pointers.set(event.pointerId, number);
    this.put(number, { ...place, force: this.strength(event), size: +this.size.value, held: event.shiftKey || Boolean(held) });
    this.element.focus({ preventScroll: true });
    event.preventDefault();
  }

  move(event) {
    const number = this.pointers.get(event.pointerId);
    if (number === undefined) return;
    const told = event.pointerType === "mouse" ? {} : { force: this.strength(event) };
    this.put(number, { ...this.place(event), ...told });
  }

  up(event) {
    const number = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (number !== undefined && !this.fingers.get(number)?.held) this.lift(number);
  }

  // The sliders are of the fingers that press now, and of those to come.
  resize() {
    for (const [number, finger] of this.fingers)
      if (finger.force) this.put(number, { force: +this.force.value, size: +this.size.value });
  }

  wheel(event) {
    const slider = event.shiftKey ? this.force : this.size, way = event.deltaY || event.deltaX;
    slider.value = +slider.value - Math.sign(way) * +slider.step * 2;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    event.preventDefault();
  }

  key(event) {
    const step = event.shiftKey ? 2 : 0.5, moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
    const sliders = { "+": [this.force, 1], "=": [this.force, 1], "-": [this.force, -1], "]": [this.size, 1], "[": [this.size, -1] }[event.key];
    const pressed = Boolean(this.fingers.get(KEY_FINGER)?.force), { left, right, bottom, top } = this.frame;
    if (moves) {
      this.keys.x = clamp(this.keys.x + moves[0], left - this.origin[0], right - this.origin[0]);
      this.keys.y = clamp(this.keys.y + moves[1], bottom - this.origin[1], top - this.origin[1]);
      this.cursor = true;
      if (pressed) this.put(KEY_FINGER, { ...this.keys });
    } else if (event.key === " " && !event.repeat) {
      if (pressed) this.lift(KEY_FINGER);
      else this.put(KEY_FINGER, { ...this.keys, force: +this.force.value, size: +this.size.value, held: true });
      this.cursor = true;
    } else if (sliders) {
      sliders[0].value = +sliders[0].value + sliders[1] * +sliders[0].step * 2;
      sliders[0].dispatchEvent(new Event("input", { bubbles: true }));
    } else if (event.key !== " ") return;
    event.preventDefault();
  }

  // What changed since the last time, as the module wants it.
  take() {
    const um = mm => Math.round(mm * 1000);
    const taken = [...this.changed].map(number => {
      const { x, y, force, size } = this.fingers.get(number);
      return [number, this.module, um(x), um(y), um(force), um(size)];
    });
    for (const number of this.changed) if (!this.fingers.get(number).force) this.fingers.delete(number);
    this.changed.clear();
    return taken;
  }

  draw(picture) {
    const [context] = fit(this.canvas), { k, x, y } = this.scale(), radius = this.head.pitch_mm * k * 0.44;
    this.most = Math.max(this.most * 0.998, 200, ...picture.counts.filter(Boolean));
    this.taxels.forEach(([tx, ty], i) => {
      const count = picture.counts[i], part = count ? Math.sqrt(count / this.most) : 0, at = [x(tx), y(ty)];
      if (count === null) disc(context, ...at, radius * 0.3, null, colors.edge, 1);
      else disc(context, ...at, radius * (0.34 + 0.66 * part), mix(colors.soft, colors.accent, part));
    });
    for (const [sx, sy, force, diameter] of picture.spheres) {
      context.globalAlpha = 0.1;
      disc(context, x(sx), y(sy), diameter / 2 * k, colors.accent);
      context.globalAlpha = 1;
      if (force > 0.02) disc(context, x(sx), y(sy), diameter / 2 * k, null, colors.accent, 1 + Math.min(force, 3) * 1.6);
    }
    const [ox, oy] = this.origin;
    for (const { x: fx, y: fy, force, size, held } of this.fingers.values()) {
      if (!force) continue;
      context.globalAlpha = 0.14;
      disc(context, x(fx + ox), y(fy + oy), size / 2 * k, colors.fg);
      context.globalAlpha = 1;
      context.setLineDash(held ? [5, 4] : []);
      disc(context, x(fx + ox), y(fy + oy), size / 2 * k, null, colors.truth, 1 + Math.min(force, 3) * 1.6);
      context.setLineDash([]);
    }
    if (this.cursor && document.activeElement === this.element) {
      const [cx, cy] = [x(this.keys.x + ox), y(this.keys.y + oy)];
      context.strokeStyle = colors.fg;
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(cx - 9, cy); context.lineTo(cx + 9, cy); context.moveTo(cx, cy - 9); context.lineTo(cx, cy + 9);
      context.stroke();
    }
    for (const contact of picture.contacts) {
      const module = this.head.modules.find(m => m.number === contact.module);
      if (module) disc(context, x(contact.at_mm[0] + module.place_mm[0]), y(contact.at_mm[1] + module.place_mm[1]), 7 * unit, colors.bad, colors.card, 2.5);
    }
  }
}
