// What all drawings share: sharp canvases, colours of the style sheet, and numbers in words.
const NAMES = ["bg", "card", "fg", "muted", "grid", "edge", "truth", "accent", "bad", "warn", "soft", "finger", "finger-dark", "hot", "w0", "w1", "w2", "w3", "w4", "w5", "w6", "w7"];
export const colors = {};

function read() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) colors[name] = style.getPropertyValue(`--${name}`).trim();
}
read();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", read);

// How much wider than on a plain screen marks and lines are: they grow with the text.
export let unit = 1;
const measure = () => { unit = parseFloat(getComputedStyle(document.documentElement).fontSize) / 15; };
measure();
addEventListener("resize", measure);

export const wireColor = wire => colors[`w${wire % 8}`];

// How large an element is, CSS pixels. Asking it each time would lay out the page anew for every drawing.
const sizes = new WeakMap();
const watch = new ResizeObserver(changed => {
  for (const { target, contentRect: { width, height } } of changed) sizes.set(target, [Math.round(width), Math.round(height)]);
  // For pages that draw only what is new.
  dispatchEvent(new Event("sized"));
});
export function size(element) {
  if (!sizes.has(element)) {
    sizes.set(element, [element.clientWidth, element.clientHeight]);
    watch.observe(element);
  }
  return sizes.get(element);
}

// A canvas at the screen's own resolution, cleared: its context, width and height in CSS pixels.
export function fit(canvas) {
  const ratio = Math.min(devicePixelRatio || 1, 3), [width, height] = size(canvas);
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return [context, width, height];
}

const parsed = new Map();
function rgb(color) {
  if (!parsed.has(color)) {
    const hex = color.slice(1), step = hex.length === 3 ? 1 : 2;
    parsed.set(color, [0, 1, 2].map(i => parseInt(hex.slice(i * step, (i + 1) * step).padStart(2, hex[i * step]), 16)));
  }
  return parsed.get(color);
}

// Between two colours, in numbers.
export function between(from, to, part) {
  const [a, b] = [from, to].map(c => (typeof c === "string" ? rgb(c) : c)), p = Math.max(0, Math.min(1, part));
  return a.map((v, i) => v + (b[i] - v) * p);
}

export const css = parts => `rgb(${parts.map(Math.round).join(",")})`;
export const mix = (from, to, part) => css(between(from, to, part));

export function disc(context, x, y, radius, fill, stroke, width = 2) {
  context.beginPath();
  context.arc(x, y, Math.max(radius, 0), 0, 2 * Math.PI);
  if (fill) { context.fillStyle = fill; context.fill(); }
  if (stroke) { context.strokeStyle = stroke; context.lineWidth = width * unit; context.stroke(); }
}

export const number = (value, digits) => value.toFixed(digits).replace("-", "\u2212");
const still = matchMedia("(prefers-reduced-motion: reduce)");
export const calm = () => still.matches;
