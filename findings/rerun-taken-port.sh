#!/usr/bin/env bash
# rerun-sdk 0.41.0: serving on a port that another program has raises nothing, and the address that it gives leads there.
#
# Expected: like every server, "address already in use" when it begins to listen.
# Found: making the sink, setting it and logging to it all return; `uri` names the taken port, so that whoever is shown
# the address meets the other program. Only `flush` raises. Whoever serves has to try the port, or to flush, before
# the address is shown to anybody.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --disable-pip-version-check -q rerun-sdk==0.41.0
cat > "$work/try.py" <<'PY'
import socket

import rerun as rr

other = socket.create_server(("127.0.0.1", 0))
port = other.getsockname()[1]
recording = rr.RecordingStream("finding")
sink = rr.GrpcServerSink("127.0.0.1", port)
recording.set_sinks(sink)
recording.log("curve", rr.Scalars(1.0))
print("nothing was raised; the address given:", sink.uri.replace(str(port), "TAKEN"))
try:
    recording.flush(timeout_sec=5.0)
    raised = ""
except Exception as problem:
    raised = type(problem).__name__
print("flush raises:", raised or "nothing")
assert str(port) in sink.uri and raised, "rerun tells of a taken port otherwise now"
PY
"$work/venv/bin/python" "$work/try.py" 2>/dev/null
