// The simulated person's hands: led by keys and by dragging, never farther ahead of them than they follow soon.

import { ask, heard } from "/talk.js";

const LEAD = 0.06; // [m] ahead of where the hands are to be, while a key is down: half a second's way
const PACE = 80; // [ms] between two targets
const FORCE = 2; // [cm] of the arrow per N
const HALF = 150; // [cm] of the view from above, to each side
const WAYS = {
  ArrowUp: [1, 0, 0],
  ArrowDown: [-1, 0, 0],
  ArrowLeft: [0, 1, 0],
  ArrowRight: [0, -1, 0],
  PageUp: [0, 0, 1],
  PageDown: [0, 0, -1],
};

// What hands do that cannot be said by where they are to be.
export const SCRIPTS = {
  take: '[[phase]]\ndo = "take_hold"',
  left: '[[phase]]\ndo = "turn"\nabout = "x"\nangle = 15\nspeed = 0.2',
  right: '[[phase]]\ndo = "turn"\nabout = "x"\nangle = -15\nspeed = 0.2',
  lower: '[[phase]]\ndo = "lower"',
  leave: '[[phase]]\ndo = "let_go"',
};

const at = (name) => document.getElementById(name);
const place = (name, x, y, turn = 0) => at(name).setAttribute("transform", `translate(${x} ${y}) rotate(${turn})`);
const attributes = (name, values) => {
  for (const [key, value] of Object.entries(values)) at(name).setAttribute(key, value);
};
const size = (vector) => Math.hypot(...vector);
// Metres of the world, x ahead and y to the left, on a screen in centimetres.
const across = (y) => -100 * y;
const down = (x) => -100 * x;

const pressed = new Set();
let target = null;
let waiting = null;
let asking = false;
let dragging = false;
let tell = () => {};
let failed = "";

async function lead() {
  if (asking) return;
  asking = true;
  while (waiting) {
    const next = waiting;
    waiting = null;
    const answer = await ask("/hand", { target: next });
    // Each of ten a second would say the same.
    if (!answer.ok && answer.said !== failed) tell(answer, "hands");
    failed = answer.ok ? "" : answer.said;
    await new Promise((done) => setTimeout(done, PACE));
  }
  asking = false;
}

function want(position) {
  target = waiting = position;
  lead();
}

const may = () => heard.state?.acts && !heard.state.forbidden.hand;
const able = () => may() && heard.state.hand;

function byKeys() {
  if (!pressed.size || !able()) return;
  const way = [0, 1, 2].map((axis) => [...pressed].reduce((sum, key) => sum + WAYS[key][axis], 0));
  const length = size(way);
  if (length) want(heard.state.hand.wanted.map((value, axis) => value + (LEAD * way[axis]) / length));
}

function onSvg(svg, event) {
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  return [point.x, point.y];
}

function draggable(svg, aim) {
  const move = (event) => {
    if (!dragging || !able()) return;
    const from = target ?? heard.state.hand.wanted;
    want(aim(onSvg(svg, event), from));
  };
  svg.addEventListener("pointerdown", (event) => {
    dragging = true;
    svg.setPointerCapture(event.pointerId);
    target = null;
    move(event);
  });
  svg.addEventListener("pointermove", move);
  for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => (dragging = false));
}

function rules() {
  const lines = [];
  for (let k = -1000; k <= 1000; k += 50) {
    lines.push(`<line x1="${k}" x2="${k}" y1="-1000" y2="1000"/><line y1="${k}" y2="${k}" x1="-1000" x2="1000"/>`);
  }
  at("floor").innerHTML = lines.join("");
  at("rule").innerHTML = [0, 50, 100, 150]
    .map((k) => `<line x1="0" x2="60" y1="${-k}" y2="${-k}"/><text x="2" y="${-k - 3}">${k / 100} m</text>`)
    .join("");
}

export function beginHands(telling) {
  tell = telling;
  rules();
  draggable(at("above"), ([x, y], from) => [-y / 100, -x / 100, from[2]]);
  draggable(at("height"), ([, y], from) => [from[0], from[1], Math.max(0, -y / 100)]);
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !(event.key in WAYS) || !may()) return;
    event.preventDefault();
    pressed.add(event.key);
  });
  document.addEventListener("keyup", (event) => pressed.delete(event.key));
  // A key that is let go elsewhere is not heard of.
  window.addEventListener("blur", () => pressed.clear());
  setInterval(byKeys, PACE);
}

const metres = (position) => ["x", "y", "z"].map((axis, k) => `${axis} ${position[k].toFixed(2)}`).join(", ") + " m";

export function showHands(state, old) {
  const no = state.acts ? state.forbidden.hand : "this is a recording: its hands cannot be led";
  at("no-hands").hidden = !no;
  at("no-hands").textContent = no;
  at("hands").hidden = Boolean(no);
  for (const button of document.querySelectorAll("[data-command]")) {
    button.disabled = old || !state.acts || Boolean(state.forbidden.task);
  }
  const task = state.task;
  at("task-state").textContent = task ? task.state : "no task was heard";
  const quiet = task && task.age > 2 ? `last heard ${task.age.toFixed(0)} s ago` : "";
  at("task-reason").textContent = [task?.reason, quiet, state.forbidden.task].filter(Boolean).join("; ");
  if (!no) showHand(state);
}

function showHand({ hand, panel, base }) {
  for (const name of ["target", "target-height"]) at(name).classList.toggle("none", !target);
  for (const name of ["hand", "wanted", "force", "hand-height", "panel"]) at(name).classList.toggle("none", !hand);
  const [bx, by] = base?.position ?? [0, 0];
  place("robot", across(by), down(bx), (-180 * (base?.yaw ?? 0)) / Math.PI);
  const [farX, farY] = (hand ?? panel ?? { position: [1, 0] }).position;
  if (!dragging) {
    const [middleX, middleY] = [(across(by) + across(farY)) / 2, (down(bx) + down(farX)) / 2];
    at("above").setAttribute("viewBox", `${middleX - HALF} ${middleY - HALF} ${2 * HALF} ${2 * HALF}`);
  }
  if (!hand) {
    at("doing").textContent = "hold nothing yet: take hold first";
    return;
  }
  at("newton").textContent = size(hand.force).toFixed(1);
  at("strain").value = size(hand.force);
  at("torque").textContent = size(hand.torque).toFixed(1);
  at("place").textContent = metres(hand.position);
  at("doing").textContent = hand.doing || "wait for you";
  const [x, y, z] = hand.position;
  place("hand", across(y), down(x));
  place("wanted", across(hand.wanted[1]), down(hand.wanted[0]));
  attributes("hand-height", { cy: down(z) });
  attributes("force", {
    x1: across(y),
    y1: down(x),
    x2: across(y) - FORCE * hand.force[1],
    y2: down(x) - FORCE * hand.force[0],
  });
  if (target) {
    place("target", across(target[1]), down(target[0]));
    place("target-height", 0, down(target[2]));
    // It is there: what comes next is counted from where the hands are.
    if (!dragging && !pressed.size && size(target.map((value, k) => value - hand.wanted[k])) < 0.005) target = null;
  }
  if (panel) {
    const [px, py] = panel.position;
    attributes("panel", { x1: across(y), y1: down(x), x2: across(2 * py - y), y2: down(2 * px - x) });
  }
}
