// What a session is of: what the page offers, what was chosen, and how that is told to the loop.
const FIELDS = { skin: "layout", illusion: "illusion.model", renderer: "illusion.render", person: "illusion.person", contacts: "compression.kc", display: "bench.display", wires: "bench.wire.kind" };
// K_C grows with the fingers up to this.
const MOST_CONTACTS = 4;
const AS_IS = { skin: "as the scene has it", illusion: "as the scene has it", renderer: "as the scene has it", person: "as the scene has it", contacts: `one for each finger, ${MOST_CONTACTS} at most`, display: "as the bench has it", wires: "as the bench has it" };

export class Settings {
  constructor(form, shelves, change) {
    Object.assign(this, { form, shelves, fields: form.elements });
    const offers = { scene: "scenes", skin: "skins", bench: "benches", display: "displays", wires: "wires", illusion: "illusions", renderer: "renderers", person: "persons" };
    for (const [field, shelf] of Object.entries(offers))
      for (const offer of shelves[shelf]) this.fields[field].add(new Option(offer.name ?? offer, offer.name ?? offer));
    for (const field of Object.keys(FIELDS)) this.fields[field].add(new Option(AS_IS[field], ""), 0);
    this.choose({ scene: "idle", bench: "emulated", set: [], observe: false });
    form.addEventListener("change", event => {
      // A scene or bench of one's own choice begins with what it says itself.
      if (event.target.name === "scene") {
        for (const field of ["skin", "illusion", "renderer", "contacts"]) this.fields[field].value = "";
        const own = shelves.scenes.find(offer => offer.name === this.fields.scene.value)?.bench;
        if (own) this.fields.bench.value = own;
      }
      if (event.target.name === "bench") for (const field of ["display", "wires"]) this.fields[field].value = "";
      this.text = null;
      this.fit();
      change();
    });
    form.addEventListener("submit", event => event.preventDefault());
  }

  // Puts what a link or button says into the form.
  choose({ scene, text = null, bench, set, observe, seed = 1 }) {
    Object.assign(this, { text, seed });
    if (scene) this.fields.scene.value = scene;
    this.fields.bench.value = bench;
    this.fields.observe.checked = observe;
    for (const [field, key] of Object.entries(FIELDS)) {
      const found = set.find(each => each.startsWith(`${key}=`));
      this.fields[field].value = found ? found.slice(key.length + 1) : "";
    }
    this.fit();
  }

  // Motors have neither wires to choose nor a guard that only looks on.
  fit() {
    const { wires, observe, bench } = this.fields, motors = Boolean(this.shelves.benches.find(offer => offer.name === bench.value)?.motors);
    wires.disabled = observe.disabled = motors;
    if (motors) [wires.value, observe.checked] = ["", false];
  }

  // The same of another version's session, whose bench may be gone.
  chooseNearest(session) {
    this.choose({ scene: "", ...session });
    if (!this.fields.bench.value) this.fields.bench.value = "emulated";
  }

  // As the loop takes it.
  chosen() {
    const stated = Object.entries(FIELDS).filter(([field]) => this.fields[field].value);
    const set = stated.map(([field, key]) => `${key}=${this.fields[field].value}`);
    if (!this.fields.contacts.value) set.push(`compression.kc_touches=${MOST_CONTACTS}`);
    const { scene, bench, observe } = this.fields, common = { bench: bench.value, set, observe: observe.checked, seed: this.seed };
    // A session's own scene has its changes in it.
    return this.text ? { text: this.text, ...common, set: set.filter(each => each.startsWith("bench.")) } : { scene: scene.value, ...common };
  }

  wantsModel() {
    if (this.text) return /^\s*\[texture/m.test(this.text);
    return Boolean(this.shelves.scenes.find(scene => scene.name === this.fields.scene.value)?.texture);
  }
}
