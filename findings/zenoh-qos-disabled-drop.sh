#!/usr/bin/env bash
# Zenoh 1.10.2 (Python): with `transport/unicast/qos/enabled: false` one moment in which a reader does not keep up ends
# every message of congestion control DROP on that connection, for as long as the connection stands.
#
# Expected: what cannot be sent is dropped, and what is put after the reader has caught up arrives, with or without QoS:
# the setting is documented as no more than whether there is one queue or one per priority. `lowlatency` demands it off,
# and is itself in force only between two sessions that both ask for it; to a router a session falls back on an ordinary
# connection, without QoS.
# Found: with QoS everything arrives again. Without it nothing does and neither side says so; the connection stands, and
# what is put as BLOCK still arrives over it. The sender marks the queue of priority DATA as congested and unmarks
# that of index 0 (zenoh-transport, src/common/pipeline.rs: push_network_message and refill).
# The reader is stopped here for 1.5 s, of a lease of 10 s. A busy machine is enough: a message waits at most 1 ms.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --disable-pip-version-check -q eclipse-zenoh==1.10.2
cat > "$work/try.py" <<'PY'
import json
import signal
import subprocess
import sys
import threading
import time

import zenoh

ENDPOINT = "tcp/127.0.0.1:17982"
KEYS = ("dropping", "blocking")
MESSAGES = 200


def open_session(mode, **settings):
    config = zenoh.Config()
    for key, value in {"mode": mode, "scouting/multicast/enabled": False, **settings}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def read():
    """Print the key of every message."""
    session = open_session("client", **{"connect/endpoints": [ENDPOINT]})
    subscriber = session.declare_subscriber("*")
    for sample in subscriber:
        print(sample.key_expr, len(sample.payload.to_bytes()), flush=True)


def heard_after_a_stop(qos):
    """How many of the small messages of each kind arrive after the reader was stopped and has caught up."""
    listen = {"listen/endpoints": [ENDPOINT], "transport/unicast/qos/enabled": qos}
    session = open_session("peer", **listen)
    reader = subprocess.Popen([sys.executable, __file__, "read"], stdout=subprocess.PIPE, text=True)
    heard = {key: 0 for key in KEYS}

    def count():
        for line in reader.stdout:
            key, size = line.split()
            heard[key] += size == "1"

    threading.Thread(target=count, daemon=True).start()
    dropping = session.declare_publisher(KEYS[0], congestion_control=zenoh.CongestionControl.DROP)
    blocking = session.declare_publisher(KEYS[1], congestion_control=zenoh.CongestionControl.BLOCK)
    while not all(heard.values()):
        dropping.put(b"x")
        blocking.put(b"x")
        time.sleep(0.01)
    reader.send_signal(signal.SIGSTOP)
    end = time.monotonic() + 1.5
    while time.monotonic() < end:
        dropping.put(bytes(40_000))
        time.sleep(0.001)
    reader.send_signal(signal.SIGCONT)
    time.sleep(1.0)
    before = dict(heard)
    for _ in range(MESSAGES):
        dropping.put(b"x")
        blocking.put(b"x")
        time.sleep(0.002)
    time.sleep(1.0)
    reader.kill()
    reader.wait()
    session.close()
    return {key: heard[key] - before[key] for key in KEYS}


if len(sys.argv) > 1:
    read()
for qos in (True, False):
    found = heard_after_a_stop(qos)
    print(f"QoS {qos}: of {MESSAGES} arrived {found}")
    assert found["blocking"] == MESSAGES
    assert found["dropping"] > 0.9 * MESSAGES if qos else found["dropping"] == 0, "Zenoh drops otherwise now"
PY
"$work/venv/bin/python" "$work/try.py"
