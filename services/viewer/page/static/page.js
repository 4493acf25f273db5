// The head of the page: the sentence, STOP, and whether what is shown is of this moment.

import { ask, heard, isOld, listen, silence, stop } from "/talk.js";
import { SCRIPTS, beginHands, showHands } from "/hands.js";
import { beginEnable, showEnable } from "/enable.js";

const QUIET = 1.5; // [s] without a word of the robot's gate
const at = (name) => document.getElementById(name);
const put = (name, text) => {
  if (at(name).textContent !== text) at(name).textContent = text;
};

function tell({ ok, said }, what = "STOP") {
  at("answer").hidden = false;
  at("answer").classList.toggle("bad", !ok);
  put("answer", `${what}: ${said}`);
  const line = document.createElement("li");
  line.textContent = `${new Date().toLocaleTimeString()} ${what}: ${said}`;
  line.classList.toggle("bad", !ok);
  at("answers").prepend(line);
  while (at("answers").children.length > 6) at("answers").lastChild.remove();
}

async function act(what, path, body) {
  tell(await ask(path, body), what);
}

const seconds = (age) => (age < 100 ? `${age.toFixed(1)} s` : `${Math.round(age / 60)} min`);

// Why what is shown must not be taken for the present; empty if it may.
function whyOld(state) {
  if (isOld()) {
    const since = heard.at < 0 ? "has not answered yet" : `is silent for ${seconds(silence() / 1000)}`;
    return `This picture is old: the viewer ${since}. STOP cannot reach the robot: stop it by its own button.`;
  }
  if (!state.acts) return "";
  if (!state.gate) return "No robot has been heard: STOP is sent all the same, but nobody may be there.";
  const age = state.gate.age + silence() / 1000;
  if (age < QUIET) return "";
  return `The robot was last heard ${seconds(age)} ago: what is shown is old. STOP is sent, but may not arrive.`;
}

function show() {
  const { state } = heard;
  const old = whyOld(state);
  at("old").hidden = !old;
  put("old", old);
  at("why").classList.toggle("old", Boolean(old));
  at("stop").classList.toggle("unable", isOld() || Boolean(state?.forbidden.stop));
  // What is typed into the picture is not heard here.
  at("stop").classList.toggle("unheard", document.activeElement === at("picture"));
  if (isOld()) put("stop-word", "STOP cannot reach the robot");
  else put("stop-word", state.forbidden.stop ? "STOP is not allowed here" : "STOP");
  if (!state) return;
  const acts = state.acts && !state.forbidden.stop;
  at("stop").hidden = at("release").hidden = !state.acts;
  at("release").disabled = !acts || isOld();
  at("stop").title = state.forbidden.stop;
  showEnable(state, isOld());
  at("why").dataset.kind = state.sentence.kind;
  put("sentence", state.sentence.text);
  put("more", state.acts ? state.sentence.more.join(" · ") : "a recording: there is nothing to stop");
  document.title = `${state.robot}: ${state.sentence.text}`;
  if (hands) showHands(state, Boolean(old));
  else frame(state);
}

// rerun's page, one port above; anew when the colours of the system change.
const dark = matchMedia("(prefers-color-scheme: dark)");
let framed = "";
function frame(state) {
  const port = Number(location.port || 80) + 1;
  // Another site by its name: the browser draws it in a process of its own, and STOP does not wait for it.
  const host = `${location.hostname === "127.0.0.1" ? "localhost" : "127.0.0.1"}:${port}`;
  const kind = state.reads === "/proxy" ? "rerun+http" : "http";
  const from = encodeURIComponent(`${kind}://${host}${state.reads}`);
  const theme = dark.matches ? "dark" : "light";
  const address = `http://${host}/?url=${from}&theme=${theme}&persist=0&hide_welcome_screen`;
  if (framed === address) return;
  framed = at("picture").src = address;
}

const hands = location.pathname === "/hands";
at(hands ? "to-hands" : "to-picture").setAttribute("aria-current", "page");
at(hands ? "desk" : "picture").hidden = false;
at("stop").addEventListener("click", () => stop(tell));
at("release").addEventListener("click", () => act("release", "/release", {}));
for (const button of document.querySelectorAll("[data-command]")) {
  const { command } = button.dataset;
  button.addEventListener("click", () => act(`task ${command}`, "/task", { command }));
}
for (const button of document.querySelectorAll("[data-script]")) {
  const script = SCRIPTS[button.dataset.script];
  button.addEventListener("click", () => act(button.textContent.trim(), "/hand", { script }));
}
document.addEventListener("keydown", (event) => {
  if (event.key !== "Escape" || event.repeat || at("stop").hidden) return;
  event.preventDefault();
  stop(tell);
});
if (hands) beginHands(tell);
beginEnable(tell);
listen();
show();
setInterval(show, 100);
