// What the experimenter sees: where the session is, what is used of the limits, and a place for notes.
import { connect } from "./desk.js";
import { LIMITS } from "./limits.js";

const by = id => document.getElementById(id);
const percent = share => `${(100 * share).toFixed(share < 0.1 ? 2 : 0)} %`;
function show(view) {
  globalThis.view = view;
  by("title").textContent = `${view.protocol}, participant ${view.participant}`;
  by("protocol").textContent = view.protocol;
  by("participant").textContent = view.participant;
  by("bench").textContent = view.bench;
  by("source").textContent = view.source.toUpperCase();
  by("source").className = view.source;
  by("step").textContent = view.begun ? view.step : `Waits until the participant says Begin on their page; then comes: ${view.step}.`;
  by("trial").textContent = view.trial ?? "";
  by("seat").textContent = view.seated ? "The participant's page is there." : "The participant's page is not there.";
  by("seat").className = view.seated ? "" : "alarm";
  by("done").value = view.done / Math.max(1, view.all);
  by("count").textContent = `${view.done} of ${view.all} trials, ${view.void} void`;
  by("lay").hidden = !view.lay;
  by("what").textContent = view.lay ? `Lay under the finger: ${view.lay}` : "";
  by("void").disabled = view.step !== "trial";
  by("said").textContent = view.said ?? "";
  by("rows").tBodies[0].replaceChildren(...view.rows.map(([row, share]) => {
    const line = document.createElement("tr");
    const name = Object.assign(document.createElement("th"), { textContent: LIMITS[row] ?? row, scope: "row" });
    const bar = Object.assign(document.createElement("meter"), { value: share, max: 1, high: 0.8, low: 0.5, optimum: 0, ariaLabel: LIMITS[row] ?? row });
    const cell = document.createElement("td"), text = Object.assign(document.createElement("td"), { textContent: percent(share) });
    cell.append(bar);
    line.append(name, cell, text);
    return line;
  }));
  by("dose").textContent = `${percent(view.planned)} of what a session may have`;
}

const desk = connect("experimenter", show, () => (by("said").textContent = "The connection is lost; it comes back by itself."));
by("stop").onclick = () => desk.say({ stop: true });
by("laid").onclick = () => desk.say({ laid: true });
by("void").onclick = () => desk.say({ void: "the experimenter said so" });
by("noting").onsubmit = event => {
  event.preventDefault();
  const text = by("note").value.trim();
  if (!text) return;
  desk.say({ note: text });
  by("noted").prepend(Object.assign(document.createElement("li"), { textContent: text }));
  by("note").value = "";
};
