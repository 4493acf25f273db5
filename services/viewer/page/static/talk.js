// What the viewer says, how old that is, and what is asked of it. STOP waits for nothing.

const PERIOD = 150; // [ms] between an answer and the next question
const OLD = 1500; // [ms] without an answer: what is shown is old
const ANSWER_WITHIN = 1000; // [ms] of a question that is asked again anyway
const ACTION_WITHIN = 6000; // [ms]: the robot is waited for, for 3 s, and whether somebody is there is found out
const STOP_FOR = 5000; // [ms] for which STOP is tried anew

const underWay = new Set();
const tabs = new BroadcastChannel("tandem");
let run = null;

// The newest state, and when it came.
export const heard = { state: null, at: -Infinity };

export const silence = () => performance.now() - heard.at;
export const isOld = () => silence() > OLD;

async function request(path, options, within) {
  const control = new AbortController();
  const timer = setTimeout(() => control.abort(), within);
  if (path !== "/stop") underWay.add(control);
  try {
    const answer = await fetch(path, { cache: "no-store", signal: control.signal, ...options });
    return await answer.json();
  } finally {
    clearTimeout(timer);
    underWay.delete(control);
  }
}

// A browser has few connections to one server: whatever hangs on them makes room for a stop, in every tab.
function makeRoom() {
  for (const control of underWay) control.abort();
}
tabs.onmessage = makeRoom;

const post = (path, body, within) =>
  request(path, { method: "POST", headers: { "X-Tandem": "page" }, body: body && JSON.stringify(body) }, within);

// { ok, said } of an action; a viewer that does not answer is an answer, too.
export async function ask(path, body) {
  try {
    return await post(path, body, ACTION_WITHIN);
  } catch {
    return { ok: false, said: "the viewer did not answer: it is not known whether that was done" };
  }
}

export async function stop(tell) {
  tabs.postMessage("stop");
  makeRoom();
  tell({ ok: true, said: "STOP is being sent" });
  const end = performance.now() + STOP_FOR;
  for (;;) {
    try {
      return tell(await post("/stop", undefined, ACTION_WITHIN));
    } catch {
      tell({ ok: false, said: "STOP cannot reach the robot: stop it by its own button" });
      if (performance.now() > end) return;
      await new Promise((done) => setTimeout(done, 100));
    }
  }
}

export async function listen() {
  for (;;) {
    try {
      const state = await request("/state", {}, ANSWER_WITHIN);
      if (run !== null && state.run !== run) location.reload();
      run = state.run;
      heard.state = state;
      heard.at = performance.now();
    } catch {
      // Its age says it.
    }
    await new Promise((done) => setTimeout(done, PERIOD));
  }
}
