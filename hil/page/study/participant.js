// What a participant sees: one screen at a time, large, and a STOP. Nothing here knows a condition, a wire or a level.
import { connect } from "./desk.js";

const screen = document.getElementById("screen");
const part = document.getElementById("part");
const progress = document.getElementById("progress");
const stop = document.getElementById("stop");
let view = 0, keys = {}, tidy = () => {};

const element = (tag, text, more = {}) => Object.assign(document.createElement(tag), { textContent: text ?? "" }, more);
const reply = what => desk.say({ view, reply: what });

function button(text, act, key) {
  const made = element("button", text, { type: "button", onclick: act });
  if (key) keys[key] = act;
  return made;
}

const paragraphs = text => (text ?? "").trim().split("\n").map(line => element("p", line));

/** A reply is given once: what was pressed twice was pressed once. */
function once(act) {
  let given = false;
  return (...of) => {
    if (given) return;
    given = true;
    act(...of);
  };
}

const screens = {
  begin: () => {
    const go = once(() => reply("read"));
    return [element("h1", "Ready?"), element("p", "Put your finger in place. Press the button, or the space bar, to begin."), button("Begin", go, " ")];
  },
  pass: () => [element("h1", "The wires warm up"), element("p", "You feel each of them once, one after the other. Nothing is asked of you yet.")],
  consent: ({ text }) => {
    const answer = once(agreed => reply({ consent: agreed }));
    const box = element("input", "", { type: "checkbox", id: "agree" });
    const label = element("label", "");
    label.append(box, " I have read this and agree to take part.");
    const yes = button("Go on", () => box.checked && answer(true));
    yes.disabled = true;
    box.onchange = () => (yes.disabled = !box.checked);
    return [element("h1", "Before we begin"), ...paragraphs(text), label, row(yes, button("I do not take part", () => answer(false)))];
  },
  instructions: ({ text }) => [element("h1", "What you do"), ...paragraphs(text), button("Go on", once(() => reply("read")), " ")],
  question: ({ text, choices }) => {
    const answer = once(number => reply({ chosen: number }));
    return [element("h1", text), ...choices.map((choice, number) => button(choice, () => answer(number), String(number + 1)))];
  },
  break: ({ seconds }) => {
    const left = element("p", "");
    const go = button("Go on", once(() => reply("read")), undefined);
    go.disabled = true;
    const until = performance.now() + 1000 * seconds;
    const tick = () => {
      const s = Math.ceil((until - performance.now()) / 1000);
      left.textContent = s > 0 ? `You can go on in ${s} s.` : "Go on whenever you like.";
      if (s <= 0) {
        go.disabled = false;
        keys[" "] = () => go.click();
        clearInterval(timer);
      }
    };
    const timer = setInterval(tick, 250);
    tidy = () => clearInterval(timer);
    tick();
    return [element("h1", "A break"), element("p", "Take the finger out and move it."), left, go];
  },
  wait: () => [element("h1", "…", { className: "calm" })],
  play: ({ interval, of }) => [element("h1", of > 1 ? String(interval) : "●", { className: "playing" })],
  interval: ({ text }) => {
    const answer = once(number => reply({ answer: { interval: number } }));
    return [element("h1", text), row(button("1", () => answer(1), "1"), button("2", () => answer(2), "2")), element("p", "Touch, or press 1 or 2.", { className: "hint" })];
  },
  ratings: ({ text, scales }) => {
    const given = scales.map(() => 0);
    const send = once(() => reply({ answer: { ratings: given } }));
    const done = button("Done", () => given.every(Boolean) && send(), "Enter");
    done.disabled = true;
    const groups = scales.map((scale, index) => {
      const group = element("fieldset", "");
      const names = element("p", "", { className: "ends" });
      names.append(element("span", scale.low), element("span", scale.high));
      const choices = element("div", "", { className: "scale" });
      for (let number = 1; number <= 6; number += 1) {
        const label = element("label", String(number));
        const input = element("input", "", { type: "radio", name: scale.name, value: number });
        input.onchange = () => {
          given[index] = number;
          done.disabled = !given.every(Boolean);
        };
        label.prepend(input);
        choices.append(label);
      }
      group.append(element("legend", scale.name), choices, names);
      return group;
    });
    // A number rates the first scale that has none yet.
    for (let number = 1; number <= 6; number += 1)
      keys[number] = () => {
        const index = given.findIndex(value => !value);
        if (index >= 0) groups[index].querySelectorAll("input")[number - 1].click();
      };
    return [element("h1", text), ...groups, done];
  },
  place: view => pad(view, false),
  path: view => pad(view, true),
  done: () => [element("h1", "Thank you"), element("p", "That was all. Take the finger out of the thimble.")],
  declined: () => [element("h1", "Thank you"), element("p", "Nothing was played, and nothing is asked of you.")],
  stopped: () => [element("h1", "Stopped"), element("p", "Everything is off. Take the finger out of the thimble.")],
};

function row(...buttons) {
  const made = element("div", "", { className: "row" });
  made.append(...buttons);
  return made;
}

/** A finger to point at or to draw on, with touch, pen, mouse or arrow keys. */
function pad({ text, frame_mm: [left, bottom, right, top] }, draws) {
  const canvas = element("canvas", "", { tabIndex: 0, ariaLabel: draws ? "Draw here" : "Point here" });
  const wide = right - left, high = top - bottom;
  canvas.style.aspectRatio = `${wide} / ${high}`;
  const strokes = [];
  let pen = null, began = null, cursor = [(left + right) / 2, (bottom + top) / 2], point = null;
  const send = once(answer => reply({ answer }));
  const done = button("Done", () => {
    if (draws && strokes.length) send({ path: strokes });
    else if (!draws && point) send({ place: point });
  });
  done.disabled = true;
  const again = button("Again", () => {
    strokes.length = 0;
    point = began = pen = null;
    done.disabled = true;
    paint();
  });
  const at = event => {
    const box = canvas.getBoundingClientRect();
    return [left + ((event.clientX - box.left) / box.width) * wide, top - ((event.clientY - box.top) / box.height) * high];
  };
  const add = ([x_mm, y_mm], stamp) => {
    began ??= stamp;
    strokes.at(-1).push({ t_ms: Math.max(0, stamp - began), x_mm, y_mm });
  };
  const mark = () => (done.disabled = draws ? !strokes.length : !point);
  canvas.onpointerdown = event => {
    if (pen !== null) return;
    pen = event.pointerId;
    canvas.setPointerCapture(pen);
    if (draws) {
      strokes.push([]);
      add(at(event), event.timeStamp);
    } else point = at(event);
    mark();
    paint();
    event.preventDefault();
  };
  canvas.onpointermove = event => {
    if (event.pointerId !== pen) return;
    // A browser hands on one event a frame, with all the points that the pen gave since the last one.
    const all = event.getCoalescedEvents?.() ?? [];
    for (const one of all.length ? all : [event])
      if (draws) add(at(one), one.timeStamp);
      else point = at(one);
    paint();
  };
  canvas.onpointerup = canvas.onpointercancel = event => {
    if (event.pointerId === pen) pen = null;
  };
  const step = Math.max(wide, high) / 60;
  let keyed = false;
  const moved = (dx, dy) => () => {
    cursor = [Math.min(right, Math.max(left, cursor[0] + dx * step)), Math.min(top, Math.max(bottom, cursor[1] + dy * step))];
    if (draws && keyed) add(cursor, performance.now());
    if (!draws) point = cursor;
    mark();
    paint();
  };
  Object.assign(keys, { ArrowLeft: moved(-1, 0), ArrowRight: moved(1, 0), ArrowUp: moved(0, 1), ArrowDown: moved(0, -1) });
  keys[" "] = () => {
    if (!draws) {
      point = cursor;
    } else {
      // The space bar puts the pen down and lifts it.
      keyed = !keyed;
      if (keyed) {
        strokes.push([]);
        add(cursor, performance.now());
      }
    }
    mark();
    paint();
  };
  keys.Enter = () => done.click();
  const paint = () => {
    const scale = devicePixelRatio || 1, box = canvas.getBoundingClientRect();
    if (!box.width) return;
    canvas.width = box.width * scale;
    canvas.height = box.height * scale;
    const brush = canvas.getContext("2d"), style = getComputedStyle(document.body);
    const ink = style.getPropertyValue("--ink"), soft = style.getPropertyValue("--line"), accent = style.getPropertyValue("--accent");
    brush.setTransform(canvas.width / wide, 0, 0, -canvas.height / high, (-left / wide) * canvas.width, (top / high) * canvas.height);
    // The outline of a fingertip seen from the nail, tip up.
    const middle = (left + right) / 2, half = 0.44 * wide, round = top - half - 0.03 * high;
    brush.lineWidth = 0.4;
    brush.strokeStyle = soft;
    brush.beginPath();
    brush.moveTo(middle - half, bottom);
    brush.lineTo(middle - half, round);
    brush.arc(middle, round, half, Math.PI, 0, true);
    brush.lineTo(middle + half, bottom);
    brush.stroke();
    brush.lineWidth = 0.6;
    brush.lineCap = brush.lineJoin = "round";
    brush.strokeStyle = accent;
    for (const stroke of strokes) {
      brush.beginPath();
      stroke.forEach(({ x_mm, y_mm }, index) => (index ? brush.lineTo(x_mm, y_mm) : brush.moveTo(x_mm, y_mm)));
      if (stroke.length === 1) brush.lineTo(stroke[0].x_mm + 0.01, stroke[0].y_mm);
      brush.stroke();
    }
    const spot = ([x, y], radius, color) => {
      brush.fillStyle = color;
      brush.beginPath();
      brush.arc(x, y, radius, 0, 2 * Math.PI);
      brush.fill();
    };
    if (point) spot(point, 1.4, accent);
    if (document.activeElement === canvas) spot(cursor, 0.7, ink);
  };
  canvas.onfocus = canvas.onblur = paint;
  const seen = new ResizeObserver(paint);
  seen.observe(canvas);
  tidy = () => seen.disconnect();
  globalThis.pad = { strokes, get point() { return point; } };
  const hint = draws ? "Finger, pen, or arrow keys; the space bar puts the pen down and lifts it." : "Touch, or arrow keys.";
  queueMicrotask(() => canvas.focus());
  return [element("h1", text), canvas, element("p", hint, { className: "hint" }), row(again, done)];
}

function show(what, number) {
  tidy();
  [tidy, keys, view] = [() => {}, {}, number];
  document.body.dataset.screen = what.screen;
  screen.replaceChildren(...(screens[what.screen]?.(what) ?? []));
  if (what.part !== undefined) {
    part.style.width = `${100 * what.part}%`;
    progress.setAttribute("aria-valuenow", Math.round(100 * what.part));
  }
  stop.hidden = ["done", "declined", "stopped"].includes(what.screen);
  globalThis.shown = what.screen;
}

function lost() {
  if (["done", "declined", "stopped"].includes(globalThis.shown)) return;
  tidy();
  [tidy, keys] = [() => {}, {}];
  globalThis.shown = "lost";
  screen.replaceChildren(element("h1", "The connection is lost"), element("p", "Nothing is played meanwhile. It comes back by itself."));
}

const desk = connect("participant", show, lost);
globalThis.desk = desk;
const halt = () => desk.say({ stop: true });
stop.onpointerdown = halt; // on the way down already
stop.onclick = halt;
addEventListener("keydown", event => {
  if (event.repeat && ![" ", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"].includes(event.key)) return;
  if (event.key === "Escape") {
    halt();
    return;
  }
  const on = document.activeElement;
  // A button that is focused takes its own keys.
  if (on?.tagName === "BUTTON" && [" ", "Enter"].includes(event.key)) return;
  const act = keys[event.key];
  if (act && !(event.repeat && event.key === " ")) {
    event.preventDefault();
    act();
  }
});
