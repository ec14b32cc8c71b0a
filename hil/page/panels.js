// What a page says in words and numbers: what is felt, limits, wires, notes.
import { number } from "palpate/draw.js";
import { LIMITS, limitsOf, measured } from "palpate/limits.js";

const by = id => document.getElementById(id);
const make = (tag, about, ...children) => { const element = Object.assign(document.createElement(tag), about); element.append(...children); return element; };
// Notes that are kept, pictures from number to number, and how long a felt place is the newest one, us.
const NOTES = 60, EVERY = 6, HOLDS_US = 400000;
// A page whose first picture is later has not seen a run from its begin, us.
const LATE_US = 1e6;
const db = value => `${number(value, 1)} dB`;
const set = (id, text) => { const element = by(id); if (element.textContent !== text) element.textContent = text; };

// Beyond a million a dose says nothing more, as in the summary.
const dose = (value, text) => (value > 1e6 ? "> 1e6" : text);

export class Panels {
  open(head) {
    this.head = head;
    // Half of the axis of levels, dB: motors shake far over threshold.
    this.level = head.motors ? 60 : 30;
    [by("level-low").textContent, by("level-high").textContent] = [`-${this.level} dB`, `+${this.level} dB`];
    document.body.classList.toggle("motors", head.motors);
    this.count = 0;
    Object.assign(this, { worst: {}, since: undefined, late: false });
    by("used").replaceChildren(...limitsOf(head).map(key => make("li", { id: `used-${key}` }, make("span", { textContent: LIMITS[key] }), make("span", { className: "meter" }, make("i"), make("b")), make("em", { textContent: "0 %" }))));
    by("used").classList.remove("both");
    this.feltAt = -Infinity;
    by("lanes").replaceChildren(...head.wires_mm.map((_, i) => make("li", { textContent: i })));
    by("wires").replaceChildren(...head.wires_mm.map((_, i) => {
      const swatch = make("i", { className: "swatch" });
      swatch.style.background = `var(--w${i % 8})`;
      return make("tr", {}, make("td", {}, swatch, `${i}`), make("td"), make("td"));
    }));
    by("notes").replaceChildren(make("li", { className: "none", textContent: "nothing to tell" }));
    set("felt-from", "From the contact");
    this.feltNowhere("nothing yet");
  }

  take(picture) {
    this.happened(picture);
    // Numbers that change with every picture cannot be read.
    if (this.count++ % EVERY === 0) this.numbers(picture);
  }

  happened(picture) {
    for (const note of picture.notes) this.note(...note);
    this.since ??= picture.now_us;
    const most = (key, share) => { this.worst[key] = Math.max(this.worst[key] ?? 0, Number.isFinite(share) ? share : 10); };
    for (const [key, share] of picture.used) most(key, share);
    // Pulses are over between two looks at the guard.
    if (picture.used.length && !this.head.motors) for (const burst of picture.bursts) most("pulse", burst.ticks / this.head.widest_ticks);
    for (const burst of picture.bursts) if (burst.reason) this.note(burst.at_us, "limiter", `guard: ${this.head.motors ? "motor" : "wire"} ${burst.wire} has ${burst.ticks} of ${burst.asked} ${this.head.motors ? "of its level" : "ticks"}: ${burst.reason}`);
    const felt = picture.felt.at(-1);
    if (felt) this.felt(felt, picture);
    // One felt place is held against one contact: of several there is none.
    else if (picture.contacts.length > 1 && picture.now_us - this.feltAt > HOLDS_US) this.feltNowhere("several contacts, no one place");
  }

  feltNowhere(why) {
    set("felt-place", why);
    for (const id of ["felt-error", "felt-level", "felt-band"]) set(id, "\u2013");
    by("level-mark").style.opacity = by("level-band").style.width = 0;
  }

  numbers(picture) {
    for (const [key, share] of picture.used) this.limit(key, share);
    const most = this.head.model_c;
    [...by("wires").rows].forEach((row, i) => picture.warm[i].forEach((celsius, n) => {
      const text = `${n ? "skin" : "wire"} ${celsius > most[n] ? `over ${most[n]} \u00b0C` : Number.isFinite(celsius) ? `${number(celsius, 1)} \u00b0C` : "\u2013"}`;
      if (row.cells[n + 1].textContent !== text) row.cells[n + 1].textContent = text;
    }));
    if (!picture.used.length && by("used-burst")) by("used").replaceChildren(make("li", { className: "none", textContent: "not recorded" }));
    const [peak, , omega, cem43] = picture.hottest ?? [], { limits_c } = this.head;
    if (!picture.hottest) set("hottest", this.recorded() ?? (picture.warm.some(w => Number.isFinite(w[1])) ? "as recorded at each stimulus" : "nothing measures temperatures on this bench"));
    else set("hottest", `hottest skin ${peak <= most[1] ? number(peak, 1) : `over ${most[1]}`} \u00b0C of ${number(limits_c.peak, 0)}; dose \u03a9 ${dose(omega, omega.toExponential(1))}, CEM43 ${dose(cem43, number(cem43, 2))} min; ${number(picture.energy_j * 1000, 0)} mJ so far`);
    const places = picture.contacts.map(c => `(${number(c.at_mm[0], 1)}, ${number(c.at_mm[1], 1)}) mm, ${number(c.counts, 0)} counts, level ${c.level}`);
    set("contacts", places.length ? `${places.length === 1 ? "contact" : `${places.length} contacts`} at ${places.join("; ")}` : "no contact");
  }

  // What a recording says of its run so far.
  recorded() {
    if (!this.sofar) return undefined;
    const { stimuli, limited, hottest_c } = this.sofar, { limits_c, model_c: [, most] } = this.head;
    const told = () => (hottest_c > most ? `over ${most}` : number(hottest_c, 1));
    const skin = Number.isFinite(hottest_c) ? `hottest skin at a stimulus ${told()} \u00b0C of ${number(limits_c.peak, 0)}; ` : "no temperature so far; ";
    return `${skin}${stimuli} ${stimuli === 1 ? "stimulus" : "stimuli"} so far, ${limited} limited by the guard`;
  }

  // The bar is now; mark and number are the most so far, which a summary is compared with.
  limit(key, share) {
    const row = by(`used-${key}`), part = Number.isFinite(share) ? Math.max(share, 0) : 10, most = Math.max(this.worst[key] ?? 0, part);
    row.classList.toggle("over", most > 1.0005);
    row.querySelector("i").style.transform = `scaleX(${Math.min(part, 1)})`;
    row.querySelector("b").style.left = `${100 * Math.min(most, 1)}%`;
    const text = most > 10 ? `${number(most, 0)} x` : `${number(most * 100, 0)} %`, told = row.querySelector("em");
    if (!this.late && told.textContent !== text) told.textContent = text;
  }

  // What the summary of a run that is over measured, beside what the guard counted; a page that came late knows little of that.
  summary(rows) {
    if (!rows.length || by("used").classList.contains("both")) return;
    this.late = !(this.since < LATE_US);
    for (const key of limitsOf(this.head)) {
      by(`used-${key}`)?.append(make("em", { textContent: measured(key, rows) ?? "\u2013" }));
      if (this.late && by(`used-${key}`)) by(`used-${key}`).querySelector("em").textContent = "\u2013";
    }
    by("used").prepend(make("li", { className: "heads" }, make("span"), make("span"), make("em", { textContent: "guard" }), make("em", { textContent: "measured" })));
    by("used").classList.add("both");
  }

  felt({ at_us, at_mm, target_mm, level_db, band_db, tap }, { fingers, spheres }) {
    // Where one thing alone touches an emulated skin, its place is known.
    const known = this.head.source !== "real" && fingers.length + spheres.filter(sphere => sphere[2] > 0).length === 1;
    this.feltAt = at_us;
    set("felt-from", known ? "From the true place" : "From the contact");
    const met = Boolean(at_mm), reached = met && level_db >= 0, mark = by("level-mark"), band = by("level-band"), x = v => `${Math.min(100, Math.max(0, 50 + 50 * v / this.level))}%`;
    set("felt-place", reached ? `(${number(at_mm[0], 1)}, ${number(at_mm[1], 1)}) mm${tap ? ", a tap" : ""}` : met ? "not felt: below threshold" : "not felt: nothing moved");
    set("felt-error", reached ? `${number(Math.hypot(at_mm[0] - target_mm[0], at_mm[1] - target_mm[1]), 2)} mm` : "\u2013");
    set("felt-level", met ? db(level_db) : "\u2013");
    set("felt-band", band_db ? `${number(band_db[0], 1)} to ${db(band_db[1])}` : "\u2013");
    mark.style.opacity = met ? 1 : 0;
    if (met) mark.style.left = x(level_db);
    band.style.left = band_db ? x(band_db[0]) : "0";
    band.style.width = band_db ? `calc(${x(band_db[1])} - ${x(band_db[0])})` : "0";
  }

  note(at_us, kind, text) {
    const list = by("notes"), first = list.firstElementChild;
    if (first?.className === "none") first.remove();
    else if (first?.dataset.text === text) { first.firstElementChild.textContent = `${number(at_us / 1e6, 2)} s`; return; }
    const line = make("li", { className: kind }, make("time", { textContent: `${number(at_us / 1e6, 2)} s` }), text);
    line.dataset.text = text;
    list.prepend(line);
    while (list.childElementCount > NOTES) list.lastElementChild.remove();
  }
}
