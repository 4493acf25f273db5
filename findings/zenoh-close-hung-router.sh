#!/usr/bin/env bash
# Zenoh 1.10.2 (Python): a client whose router hangs cannot be closed for ten seconds once it dials it anew.
#
# Expected: closing ends what this end has; whoever is at the other end learns of it, or does not. So it takes
# milliseconds, as it does while the router runs and after it was killed.
# Found: with a router that is stopped (SIGSTOP) it depends on the lease. Within it closing takes milliseconds. After it
# the client dials anew, the system takes the connection for the router, and Session.close() waits for the dialling:
# up to ten seconds, then it may raise ZError "close operation timed out". Who has to end sooner has to close aside.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --disable-pip-version-check -q eclipse-zenoh==1.10.2
cat > "$work/try.py" <<'PY'
import json
import os
import signal
import subprocess
import sys
import time

import zenoh

PLACE = "tcp/127.0.0.1:17985"


def session(mode, **more):
    config = zenoh.Config()
    for key, value in {"mode": mode, "scouting/multicast/enabled": False,
                       "transport/link/tx/lease": 1000, **more}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


if sys.argv[1:] == ["router"]:
    kept = session("router", **{"listen/endpoints": [PLACE]})
    print("up", flush=True)
    sys.stdin.read()
    os._exit(0)

said = {}
CASES = (
    ("runs", None, 0.2), ("was killed", signal.SIGKILL, 2.5),
    ("hangs, within the lease", signal.SIGSTOP, 0.2), ("hangs, beyond the lease", signal.SIGSTOP, 2.5),
)
for how, number, wait in CASES:
    router = subprocess.Popen([sys.executable, __file__, "router"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        router.stdout.readline()
        client = session("client", **{"connect/endpoints": [PLACE]})
        publisher = client.declare_publisher("a/key")
        for _ in range(20):
            publisher.put(b"payload")
            time.sleep(0.01)
        if number is not None:
            router.send_signal(number)
            time.sleep(wait)
        begun, text = time.monotonic(), "no error"
        try:
            client.close()
        except zenoh.ZError as problem:
            text = str(problem).split(" at ")[0]
        said[how] = time.monotonic() - begun, text
        print(f"router {how}: closed after {said[how][0]:.2f} s, {text}", flush=True)
    finally:
        router.send_signal(signal.SIGCONT)
        router.kill()
        router.wait()

*soon, last = said.values()
assert all(took < 1.0 and text == "no error" for took, text in soon), said
assert last[0] > 4.0, said
os._exit(0)
PY
"$work/venv/bin/python" "$work/try.py"
echo "as found"
