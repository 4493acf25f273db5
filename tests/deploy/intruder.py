"""What somebody tries who is in the containers' network, in one: ``python intruder.py ENDPOINT FOLDER``.

It comes with what the folder has, a certificate or none, subscribes to everything, says stop and asks for
parameters for a while, and prints as JSON what came of it. Nothing of the product's own checks is in its way.
"""

from __future__ import annotations

import itertools
import json
import sys
import time
from pathlib import Path

import zenoh

from shared.messages import Header, Stop
from shared.topics import CONTROL_PARAMETERS, STOP
from shared.wire.codec import encode, encode_map

TRIED = 3.0  # [s]
TLS = "transport/link/tls"
FILES = {
    "authority.pem": "root_ca_certificate",
    "certificate.pem": "connect_certificate",
    "key.pem": "connect_private_key",
}


def main(endpoint: str, folder: Path) -> None:
    """Try it, and print what came of it."""
    held = {f"{TLS}/{setting}": str(folder / file) for file, setting in FILES.items() if (folder / file).exists()}
    settings = {"mode": "client", "connect/endpoints": [endpoint], "connect/timeout_ms": 3000, **held}
    settings[f"{TLS}/enable_mtls"] = len(held) == len(FILES)
    config = zenoh.Config()
    for name, value in settings.items():
        config.insert_json5(name, json.dumps(value))
    found = {"router": False, "heard": False, "answered": False}
    try:
        with zenoh.open(config) as session:
            session.declare_subscriber("**", lambda _: found.update(heard=True))
            deadline = time.monotonic() + TRIED
            for sequence in itertools.count():
                header = Header(sequence, 1, time.monotonic_ns(), True)
                session.put(f"tiago/{STOP.key}", encode(Stop(engaged=True, reason="intruder"), header))
                replies = session.get(f"tiago/{CONTROL_PARAMETERS.key}", payload=encode_map({}), timeout=0.5)
                found["answered"] |= any(reply.ok for reply in replies)
                found["router"] |= bool(session.info.routers_zid())
                if time.monotonic() > deadline:
                    break
    except zenoh.ZError as problem:
        print(problem, file=sys.stderr)
    print(json.dumps(found), flush=True)


main(sys.argv[1], Path(sys.argv[2]))
