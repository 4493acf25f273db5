// The enabling device: the robot moves only while this button is held, by pointer or by the space bar.

import { ask } from "/talk.js";

const PERIOD = 50; // [ms] between two words of it; after 200 ms without one the robot stops
const button = document.getElementById("enable");

let pressed = false;
let saying = false;
let tell = () => {};

async function say() {
  if (saying) return;
  saying = true;
  let wanted;
  do {
    wanted = pressed;
    const answer = await ask("/enable", { pressed: wanted });
    if (!answer.ok) {
      tell(answer, "hold to move");
      pressed = false;
    }
    if (pressed) await new Promise((done) => setTimeout(done, PERIOD));
  } while (pressed || wanted);
  saying = false;
}

function press(now) {
  pressed = now && !button.disabled;
  button.classList.toggle("pressed", pressed);
  if (pressed) say();
}

export function beginEnable(how) {
  tell = how;
  button.addEventListener("pointerdown", (event) => {
    button.setPointerCapture(event.pointerId);
    press(true);
  });
  button.addEventListener("keydown", (event) => {
    if (event.key === " " && !event.repeat) press(true);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture", "keyup", "blur"]) {
    button.addEventListener(end, () => press(false));
  }
  // What is let go elsewhere is not heard of.
  window.addEventListener("blur", () => press(false));
  document.addEventListener("visibilitychange", () => press(false));
}

export function showEnable(state, old) {
  button.hidden = !state.acts || !state.gate?.require_enable;
  button.disabled = old || Boolean(state.forbidden.enable);
  button.title = state.forbidden.enable || "the robot moves only while this is held, or a key in `tandem enable`";
  if (button.hidden || button.disabled) press(false);
}
