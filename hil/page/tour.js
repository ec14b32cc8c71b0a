// A tour of six steps: from a touch to what is felt.
import { calm } from "palpate/draw.js";

const by = id => document.getElementById(id);
const STEPS = [
  ["panel-skin", "Touch the skin", "Press and drag on the dots, or tab to them and press Space. A soft pad with magnets turns your force into counts, a hundred times per second, with noise as measured."],
  ["panel-skin", "A contact", "The red dot is all that is sent on: a place, an intensity, a level. Sixteen taxels became three numbers."],
  ["panel-finger", "Between the wires", "Eight wires sit on a fingertip. Two or three of them together are felt at one place between them: a phantom. The ring is where the contact is, the dot where a person would feel it."],
  ["panel-pulses", "Pulses", "A wire gets short pulses for 38 ms or less, heats, shrinks and tugs at the skin. Set the speed to 1/100 to see each pulse."],
  ["panel-budget", "The guard", "Nothing reaches a wire that the guard has not passed. Stay on one place and watch power and warmth use up their limits: the guard makes pulses narrower. Choose the bench thesis and the illusion phantom, let the guard only look on, and watch the skin burn."],
  ["share", "Share it", "Your session is a link, and a scene in a file. Opened anywhere it gives the same pulses, to the bit, here and in hil run."],
];

export class Tour {
  constructor(opener) {
    Object.assign(this, { opener, at: -1, card: by("tour-card") });
    opener.addEventListener("click", () => this.show(0));
    by("tour-next").addEventListener("click", () => this.show(this.at + 1));
    by("tour-back").addEventListener("click", () => this.show(this.at - 1));
    by("tour-end").addEventListener("click", () => this.end());
    this.card.addEventListener("keydown", event => event.key === "Escape" && this.end());
  }

  show(at) {
    if (at < 0 || at >= STEPS.length) return this.end();
    const [place, title, text] = STEPS[at];
    document.querySelector(".lit")?.classList.remove("lit");
    by(place).classList.add("lit");
    by(place).scrollIntoView({ block: "center", behavior: calm() ? "auto" : "smooth" });
    [by("tour-title").textContent, by("tour-text").textContent] = [title, text];
    by("tour-where").textContent = `${at + 1} of ${STEPS.length}`;
    by("tour-back").disabled = at === 0;
    by("tour-next").textContent = at === STEPS.length - 1 ? "Done" : "Next";
    [this.at, this.card.hidden] = [at, false];
    by("tour-next").focus({ preventScroll: true });
  }

  end() {
    document.querySelector(".lit")?.classList.remove("lit");
    this.card.hidden = true;
    this.opener.focus();
  }
}
