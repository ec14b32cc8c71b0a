// What goes by in time: pulses of every wire, and temperatures.
import { colors, fit, number, size, unit, wireColor } from "palpate/draw.js";

const WARM_US = 30e6, WARM_EVERY_US = 100000, KEEP_US = 4e6;
// The axis of temperatures, degrees C; it grows where the skin burns.
const LOW = 32, HIGH = 44;

export class Plots {
  constructor(pulses, warm, high, low) {
    Object.assign(this, { pulses, warm, high, low });
  }

  open(head) {
    this.head = head;
    this.bursts = [];
    this.pulsed = [];
    this.on = head.wires_mm.map(() => null);
    this.warmed = [];
    this.holes = [];
    this.drawn = "";
  }

  // What was before the first picture, as a recording tells it.
  begin({ from_us, warm }) {
    this.warmed = warm.map(([at, celsius]) => [at, celsius.map(c => c ?? NaN)]);
    if (from_us > 0) this.holes.push([0, from_us]);
    this.drawn = "";
  }

  // From when to when nothing is known, us.
  hole(from, to) {
    this.holes.push([from, to]);
    this.on.fill(null);
    this.warmed.push([to, []]);
  }

  take(picture) {
    this.bursts.push(...picture.bursts);
    for (const [at, wire, high] of picture.edges) {
      if (high) this.on[wire] = at;
      else if (this.on[wire] !== null) { this.pulsed.push([this.on[wire], at, wire]); this.on[wire] = null; }
    }
    const old = picture.now_us - KEEP_US;
    if (this.bursts.length && this.bursts[0].until_us < old) this.bursts = this.bursts.filter(b => b.until_us >= old);
    if (this.pulsed.length && this.pulsed[0][1] < old) this.pulsed = this.pulsed.filter(p => p[1] >= old);
    if (picture.now_us - (this.warmed.at(-1)?.[0] ?? -Infinity) >= WARM_EVERY_US) this.warmed.push([picture.now_us, picture.warm.map(w => w[1])]);
    while (this.holes.length && this.holes[0][1] < picture.now_us - WARM_US) this.holes.shift();
    while (this.warmed.length && this.warmed[0][0] < picture.now_us - WARM_US) this.warmed.shift();
  }

  draw(picture, span) {
    this.lanes(picture, span);
    this.temperatures(picture);
  }

  // `span` microseconds up to now. Pulses are a fifth of a millisecond: where that is less than a dot, bursts stand for them.
  lanes(picture, span) {
    const [context, width, height] = fit(this.pulses), lane = height / this.head.wires_mm.length, from = picture.now_us - span;
    const x = at => (at - from) / span * width, single = span < 0.3e6;
    context.strokeStyle = colors.grid;
    context.lineWidth = 1;
    this.hatch(context, x, width, height);
    this.head.wires_mm.forEach((_, i) => { context.beginPath(); context.moveTo(0, (i + 1) * lane - 0.5); context.lineTo(width, (i + 1) * lane - 0.5); context.stroke(); });
    for (const { at_us, until_us, wire, ticks, asked } of this.bursts) {
      if (until_us < from) continue;
      const [left, right] = [x(at_us), x(Math.min(until_us, Math.max(picture.now_us, at_us)))], tall = part => Math.max(2, (lane - 6) * Math.min(1, part / this.head.widest_ticks)), base = (wire + 1) * lane - 2;
      context.globalAlpha = single ? 0.28 : 1;
      context.fillStyle = wireColor(wire);
      if (ticks) context.fillRect(left, base - tall(ticks), Math.max(right - left, 1.5), tall(ticks));
      context.globalAlpha = 1;
      if (asked > ticks) { context.strokeStyle = colors.warn; context.strokeRect(left, base - tall(asked), Math.max(right - left, 1.5), tall(asked)); }
    }
    if (!single) return;
    for (const [begin, end, wire] of this.pulsed) {
      if (end < from) continue;
      context.fillStyle = wireColor(wire);
      context.fillRect(x(begin), wire * lane + 3, Math.max(x(end) - x(begin), 1.5), lane - 5);
    }
  }

  hatch(context, x, width, height) {
    context.strokeStyle = colors.edge;
    context.lineWidth = 1;
    for (const [from, to] of this.holes) {
      const [left, right] = [Math.max(x(from), 0), Math.min(x(to), width)];
      if (right <= left) continue;
      context.save();
      context.beginPath(); context.rect(left, 0, right - left, height); context.clip();
      context.beginPath();
      for (let at = left - height; at < right; at += 9) { context.moveTo(at, height); context.lineTo(at + height, 0); }
      context.stroke();
      context.restore();
    }
  }

  temperatures(picture) {
    // Nothing of it changes faster than its values, of which there are ten per second.
    const drawn = [Math.floor(picture.now_us / WARM_EVERY_US), size(this.warm), unit, colors.bad, this.holes.length, this.warmed.length].join();
    if (this.drawn === drawn) return;
    this.drawn = drawn;
    const [context, width, height] = fit(this.warm), [, most] = this.head.model_c;
    // Beyond the model a temperature is no number, so its line ends there.
    const within = c => c <= most, beyond = this.warmed.some(w => w[1].some(c => c > most));
    const hottest = Math.max(HIGH, ...this.warmed.flatMap(w => w[1].filter(within))), high = hottest > HIGH ? Math.ceil(hottest / 5) * 5 : HIGH;
    const x = at => width * (1 - (picture.now_us - at) / WARM_US), y = celsius => height * (high - celsius) / (high - LOW);
    [this.high.textContent, this.low.textContent] = [`${high} \u00b0C${beyond ? `; not drawn over ${most} \u00b0C, where the model ends` : ""}`, `${LOW} \u00b0C`];
    context.strokeStyle = colors.bad;
    context.lineWidth = 1.5 * unit;
    context.setLineDash([7, 5]);
    context.beginPath(); context.moveTo(0, y(this.head.limits_c.peak)); context.lineTo(width, y(this.head.limits_c.peak)); context.stroke();
    context.setLineDash([]);
    this.hatch(context, x, width, height);
    this.head.wires_mm.forEach((_, wire) => {
      context.strokeStyle = wireColor(wire);
      context.lineWidth = 2 * unit;
      context.beginPath();
      let down = false;
      for (const [at, celsius] of this.warmed) {
        const known = within(celsius[wire]);
        if (known) (down ? context.lineTo(x(at), y(celsius[wire])) : context.moveTo(x(at), y(celsius[wire])));
        down = known;
      }
      context.stroke();
    });
  }
}

export const span = us => (us >= 1e6 ? `${number(us / 1e6, 0)} s ago` : us >= 1e3 ? `${number(us / 1e3, 0)} ms ago` : `${number(us, 0)} \u00b5s ago`);
