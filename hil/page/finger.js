// The person's finger, unrolled and in three dimensions, with wires, warmth and what is felt.
import { between, calm, colors, css, disc, fit, mix, unit, wireColor } from "palpate/draw.js";

const REST = 33, HOT = 43;
// How far a wire's warmth is drawn, mm, and how long a driven wire stays bright, us.
const SPREAD = 4.5, GLOW = 160000;
// Steps of light and of warmth.
const SHADES = 60;

export class Finger {
  constructor(flat, solid) {
    Object.assign(this, { flat, solid, yaw: 0.5, held: null });
    solid.addEventListener("pointerdown", event => { this.held = event.clientX - this.yaw * 90; solid.setPointerCapture(event.pointerId); });
    solid.addEventListener("pointermove", event => { if (this.held !== null) this.yaw = (event.clientX - this.held) / 90; });
    for (const name of ["pointerup", "pointercancel"]) solid.addEventListener(name, () => { this.held = null; });
  }

  open(head) {
    this.head = head;
    this.driven = head.wires_mm.map(() => ({ until: -1, part: 0 }));
    this.trail = [];
    for (const label of this.labels ?? []) label.remove();
    // Numbers are text of the page, so that they can be read out and marked.
    this.labels = head.wires_mm.map((_, i) => Object.assign(document.createElement("span"), { textContent: i }));
    this.flat.after(...this.labels);
    this.labelled = "";
    const xs = head.wires_mm.map(w => w[0]), ys = head.wires_mm.map(w => w[1]), half = head.wire_mm / 2;
    const round = head.finger_mm ? Math.PI * head.finger_mm[0] / 2 : 0;
    const wide = Math.max(...xs.map(Math.abs)) + half + 2;
    this.box = { left: -wide, right: wide, bottom: Math.min(...ys) - 6, top: Math.max(...ys) + 6 };
    // The unrolled surface is no wider than the finger is round.
    if (round) [this.box.left, this.box.right] = [-Math.min(wide, round), Math.min(wide, round)];
    this.solidMesh = this.mesh();
  }

  take(picture) {
    for (const burst of picture.bursts)
      if (burst.ticks) this.driven[burst.wire] = { until: burst.until_us, part: Math.min(1, 0.35 + 0.65 * burst.ticks / this.head.widest_ticks) };
    for (const felt of picture.felt) if (felt.at_mm && felt.level_db >= 0) this.trail.push(felt);
    if (this.trail.length > 12) this.trail.splice(0, this.trail.length - 12);
    this.felt = picture.felt.at(-1) ?? this.felt;
    if (this.felt && picture.now_us - this.felt.at_us > 400000) { this.felt = null; this.trail.length = 0; }
  }

  // Places along a wire, or around a motor's face, mm.
  outline([wx, wy]) {
    const size = this.head.wire_mm, parts = this.head.motors ? 16 : 8;
    return Array.from({ length: parts + 1 }, (_, n) => {
      const turned = 2 * Math.PI * n / parts;
      return this.head.motors ? [wx + size / 2 * Math.cos(turned), wy + size / 2 * Math.sin(turned)] : [wx + size * (n / parts - 0.5), wy];
    });
  }

  glow(wire, now) {
    const { until, part } = this.driven[wire];
    return until < 0 ? 0 : part * Math.max(0, 1 - Math.max(0, now - until) / GLOW);
  }

  draw(picture) {
    this.unrolled(picture);
    this.worn(picture);
  }

  unrolled(picture) {
    const [context, width, height] = fit(this.flat), { left, right, bottom, top } = this.box, rim = 10;
    // Not laid out yet.
    if (Math.min(width, height) <= 2 * rim) return;
    const k = Math.min((width - 2 * rim) / (right - left), (height - 2 * rim) / (top - bottom));
    const x = mm => width / 2 + (mm - (left + right) / 2) * k, y = mm => height / 2 - (mm - (bottom + top) / 2) * k;
    if (this.labelled !== `${width} ${height}`) {
      this.labelled = `${width} ${height}`;
      this.head.wires_mm.forEach(([wx, wy], i) => Object.assign(this.labels[i].style, { left: `${x(wx)}px`, top: `${y(wy)}px` }));
    }
    context.beginPath();
    const r = Math.min((right - left) / 2, 14) * k * (this.head.finger_mm ? 1 : 0.15);
    context.roundRect(x(left), y(top), (right - left) * k, (top - bottom) * k, [r, r, 6, 6]);
    context.fillStyle = mix(colors.card, colors.finger, 0.55);
    context.fill();
    context.save();
    context.clip();
    this.head.wires_mm.forEach(([wx, wy], i) => {
      const heat = Math.min(1, Math.max(0, (picture.warm[i][1] - REST) / (HOT - REST)));
      if (heat < 0.005) return;
      const gradient = context.createRadialGradient(x(wx), y(wy), 0, x(wx), y(wy), 9 * k);
      gradient.addColorStop(0, colors.hot);
      gradient.addColorStop(1, "transparent");
      context.globalAlpha = Math.min(0.9, heat * 1.4);
      context.fillStyle = gradient;
      context.fillRect(x(wx) - 9 * k, y(wy) - 9 * k, 18 * k, 18 * k);
    });
    context.restore();
    context.globalAlpha = 1;
    context.lineCap = "round";
    this.head.wires_mm.forEach((place, i) => {
      const glow = this.glow(i, picture.now_us);
      context.strokeStyle = glow ? wireColor(i) : colors.edge;
      context.lineWidth = (3 + 5 * glow) * unit;
      context.beginPath();
      for (const [mx, my] of this.outline(place)) context.lineTo(x(mx), y(my));
      context.stroke();
    });
    this.marks(context, picture, ([mx, my]) => [x(mx), y(my), 1], k);
  }

  // Contacts, fingers, felt places and their trail, by a function from the surface to the drawing.
  marks(context, picture, to, k) {
    for (const contact of picture.contacts) {
      const at = contact.on_mm && to(contact.on_mm);
      if (at?.[2]) disc(context, at[0], at[1], 11 * unit, null, colors.truth, 3);
    }
    for (const [, place] of picture.fingers) {
      const at = to(place), arm = 15 * unit;
      if (!at[2]) continue;
      context.strokeStyle = colors.fg;
      context.lineWidth = 1.5 * unit;
      context.beginPath();
      context.moveTo(at[0] - arm, at[1]); context.lineTo(at[0] + arm, at[1]); context.moveTo(at[0], at[1] - arm); context.lineTo(at[0], at[1] + arm);
      context.stroke();
    }
    this.trail.forEach((felt, i) => {
      const at = to(felt.at_mm);
      context.globalAlpha = 0.12 + 0.3 * i / this.trail.length;
      if (at[2]) disc(context, at[0], at[1], 3.5 * unit, colors.bad);
    });
    context.globalAlpha = 1;
    const newest = this.felt;
    if (!newest?.at_mm) return;
    const at = to(newest.at_mm), felt = newest.level_db >= 0;
    if (!at[2]) return;
    context.globalAlpha = 0.22;
    if (felt) disc(context, at[0], at[1], (1.2 + newest.level_db * 0.12) * k, colors.bad);
    context.globalAlpha = 1;
    disc(context, at[0], at[1], 7 * unit, felt ? colors.bad : null, felt ? colors.card : colors.bad, 2);
  }

  // From the unrolled surface to space: a cylinder whose end is a half sphere, or a plane.
  place(mx, my) {
    if (!this.head.finger_mm) return [mx, my, 0, 0, 0, 1];
    const [diameter, tip] = this.head.finger_mm, radius = diameter / 2, around = mx / radius;
    const up = Math.min(Math.max(my - tip, 0) / radius, Math.PI / 2), wide = Math.cos(up);
    const normal = [wide * Math.sin(around), Math.sin(up), wide * Math.cos(around)];
    return [radius * normal[0], Math.min(my, tip) + radius * normal[1], radius * normal[2], ...normal];
  }

  // The surface in pieces: corners in space, and of each piece its corners, its normal and how near it is to which wires.
  mesh() {
    const flat = !this.head.finger_mm, { bottom, top, right } = this.box, [diameter, tip] = this.head.finger_mm ?? [0, 0];
    const [low, high] = flat ? [bottom, top] : [bottom - 5, tip + diameter / 2], end = flat ? top : tip + Math.PI * diameter / 4;
    const half = flat ? right : Math.PI * diameter / 2, rows = 26, columns = flat ? 20 : 36;
    const at = (column, row) => [-half + 2 * half * column / columns, low + (end - low) * row / rows];
    const corners = [], pieces = [];
    for (let row = 0; row <= rows; row++) for (let column = 0; column <= columns; column++) {
      corners.push(this.place(...at(column, row)));
      if (row === rows || column === columns) continue;
      const first = row * (columns + 1) + column, [x, y] = at(column + 0.5, row + 0.5);
      const wires = this.head.wires_mm.map(([wx, wy], i) => {
        const dx = Math.max(Math.abs(x - wx) - this.head.wire_mm / 2, 0);
        return [i, Math.exp(-(dx * dx + (y - wy) ** 2) / (SPREAD * SPREAD))];
      });
      pieces.push({ corners: [first, first + 1, first + columns + 2, first + columns + 1], normal: this.place(x, y).slice(3), wires: wires.filter(near => near[1] > 0.003) });
    }
    return { corners, pieces, middle: (low + high) / 2, tall: high - low, wide: flat ? 2 * right : diameter * 1.35, xs: new Float32Array(corners.length), ys: new Float32Array(corners.length) };
  }

  // Pieces by their colour, which is the skin's in the light that it has, and warmth: drawn at once where it is the same.
  surface(context, picture, turn, to) {
    const { corners, pieces, xs, ys } = this.solidMesh, { warm } = picture, alike = new Map();
    corners.forEach(([x, y, z], i) => { [xs[i], ys[i]] = to(x, y, z); });
    for (const piece of pieces) {
      const [nx, ny, nz] = turn(...piece.normal);
      if (nz <= 0.03) continue;
      let heat = 0;
      for (const [wire, near] of piece.wires) heat = Math.max(heat, near * (warm[wire][1] - REST) / (HOT - REST));
      const light = Math.max(0, -0.27 * nx + 0.5 * ny + 0.8 * nz), key = Math.round(light * SHADES) * 1000 + Math.round(Math.min(0.92, heat * 1.3) * SHADES);
      if (!alike.has(key)) alike.set(key, []);
      alike.get(key).push(piece.corners);
    }
    context.lineWidth = 1;
    for (const [key, all] of alike) {
      const shade = between(colors["finger-dark"], colors.finger, 0.25 + 0.75 * Math.floor(key / 1000) / SHADES);
      context.beginPath();
      for (const [a, b, c, d] of all) {
        context.moveTo(xs[a], ys[a]); context.lineTo(xs[b], ys[b]); context.lineTo(xs[c], ys[c]); context.lineTo(xs[d], ys[d]);
        context.closePath();
      }
      // The outline closes the seams between the pieces.
      context.fillStyle = context.strokeStyle = css(between(shade, colors.hot, key % 1000 / SHADES));
      context.fill();
      context.stroke();
    }
  }

  worn(picture) {
    const [context, width, height] = fit(this.solid), { middle, tall, wide } = this.solidMesh;
    const yaw = this.yaw + (calm() || this.held !== null ? 0 : 0.35 * Math.sin(performance.now() / 4200)), [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    const tilt = 0.22, [ct, st] = [Math.cos(tilt), Math.sin(tilt)], k = Math.min(width / wide, height / tall) * 0.9;
    const turn = (x, y, z) => { const w = z * c - x * s; return [x * c + z * s, y * ct - w * st, w * ct + y * st]; };
    const screen = (x, y, z) => { const [u, v] = turn(x, y - middle, z); return [width / 2 + u * k, height / 2 - v * k]; };
    const to = ([mx, my]) => {
      const [x, y, z, ...normal] = this.place(mx, my);
      return [...screen(x, y, z), turn(...normal)[2] > 0.03 ? 1 : 0];
    };
    this.surface(context, picture, turn, screen);
    context.lineCap = "round";
    this.head.wires_mm.forEach((place, i) => {
      const glow = this.glow(i, picture.now_us);
      context.strokeStyle = glow ? wireColor(i) : colors.edge;
      context.lineWidth = (3.5 + 5 * glow) * unit;
      context.beginPath();
      let down = false;
      for (const at of this.outline(place)) {
        const [px, py, seen] = to(at);
        if (seen) (down ? context.lineTo(px, py) : context.moveTo(px, py));
        down = Boolean(seen);
      }
      context.stroke();
    });
    this.marks(context, picture, to, k);
  }
}
