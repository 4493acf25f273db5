#!/usr/bin/env bash
# Zenoh 1.10.2 (Python): asking for liveliness tokens while a subscriber for them is declared is answered by what that
# subscriber has been told, and not by the router.
#
# Expected: `liveliness().get()` asks the router, whatever else the session has declared. Then of two clients that first
# declare a token and ask afterwards, at least one sees the other's: the router has both tokens by the second question.
# Found: that holds without a subscriber (0 of 50 pairs missed each other). With one, most pairs do: each is answered at
# once, from before the other's token has reached it. Whoever lets one of two in by that rule must not be subscribed yet.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --disable-pip-version-check -q eclipse-zenoh==1.10.2
cat > "$work/try.py" <<'PY'
import json
import threading

import zenoh

ENDPOINT = "tcp/127.0.0.1:17981"
PAIRS = 50


def open_session(mode, **endpoints):
    config = zenoh.Config()
    for key, value in {"mode": mode, "scouting/multicast/enabled": False, **endpoints}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def missed(subscribed):
    """How many pairs of clients, of which each declares a token and then asks for all, miss each other both."""
    both = 0
    for pair in range(PAIRS):
        room = f"room/{subscribed}/{pair}"
        clients = [open_session("client", **{"connect/endpoints": [ENDPOINT]}) for _ in range(2)]
        held = [client.liveliness().declare_subscriber(f"{room}/*", lambda _: None, history=True)
                for client in clients if subscribed]
        ready, alone, tokens = threading.Barrier(2), [], []

        def enter(client, name):
            ready.wait()
            tokens.append(client.liveliness().declare_token(f"{room}/{name}"))
            seen = {str(reply.ok.key_expr) for reply in client.liveliness().get(f"{room}/*", timeout=2.0) if reply.ok}
            alone.append(seen <= {f"{room}/{name}"})

        threads = [threading.Thread(target=enter, args=pair_) for pair_ in zip(clients, "ab")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        both += all(alone)
        del held
        for client in clients:
            client.close()
    return both


router = open_session("router", **{"listen/endpoints": [ENDPOINT]})
without, with_subscriber = missed(False), missed(True)
print(f"pairs of {PAIRS} that missed each other: {without} without a subscriber, {with_subscriber} with one")
router.close()
assert without == 0 and with_subscriber >= PAIRS // 4, "Zenoh answers otherwise now"
PY
"$work/venv/bin/python" "$work/try.py"
