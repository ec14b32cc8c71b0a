// Values under the pointer of every chart, or by arrow keys: the place nearest to it, and what each line has there.
"use strict";
for (const figure of document.querySelectorAll("figure.chart[data-v]")) {
  const svg = figure.querySelector("svg"), frame = svg.querySelector(".frame"), places = JSON.parse(figure.dataset.v);
  if (!places.length) continue;
  const make = (tag, about, where) => where.appendChild(Object.assign(document.createElement(tag), about));
  const read = make("div", { className: "read", hidden: true }, figure), cursor = document.createElementNS(svg.namespaceURI, "path");
  read.setAttribute("aria-live", "polite");
  cursor.setAttribute("class", "cursor");
  svg.append(cursor);
  const { x, y, width, height } = Object.fromEntries(["x", "y", "width", "height"].map(name => [name, frame[name].baseVal.value]));
  let at = null;
  const show = place => {
    if (place === at) return;
    at = place;
    read.hidden = at === null;
    cursor.setAttribute("d", at === null ? "" : `M${places[at][0]} ${y}v${height}`);
    if (at === null) return;
    const [px, words, lines] = places[at];
    read.classList.toggle("left", px > x + width / 2);
    read.replaceChildren();
    make("b", { textContent: words }, read);
    for (const [color, text] of lines) {
      const row = make("span", {}, read);
      make("i", {}, row).style.background = `var(--w${color})`;
      row.append(` ${text}`);
    }
  };
  const point = event => {
    const { x: px } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const away = n => Math.abs(places[n][0] - px);
    show(places.reduce((best, _, n) => away(n) < away(best) ? n : best, 0));
  };
  for (const kind of ["pointermove", "pointerdown"]) figure.addEventListener(kind, point);
  for (const kind of ["pointerleave", "blur"]) figure.addEventListener(kind, () => show(null));
  figure.addEventListener("keydown", event => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === "Escape") show(null);
    if (!step) return;
    event.preventDefault();
    show(Math.min(Math.max((at ?? (step > 0 ? -1 : places.length)) + step, 0), places.length - 1));
  });
}
