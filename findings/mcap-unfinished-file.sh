#!/usr/bin/env bash
# mcap 1.6.0 (Python): of a file whose writer was killed, the usual reader gives nothing, and so does the one that reads
# from the front as long as it sorts; only in the order of the file is all there.
#
# Expected: a format made to be read from the front gives what is whole of a file that breaks off, whichever reader is
# taken, and says then that it broke off.
# Found: `make_reader` on the file looks for the summary at its end and raises before the first message. `NonSeekingReader`
# reads from the front, but sorts by time by default, for which it first reads to the end: it raises before the first
# message, too. With `log_time_order=False` it gives every message that was flushed, and raises after them.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --disable-pip-version-check -q mcap==1.6.0
cat > "$work/try.py" <<'PY'
import io

from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import Writer

MESSAGES = 100
stream = io.BytesIO()
writer = Writer(stream)
writer.start()
channel = writer.register_channel(topic="wrench", message_encoding="json", schema_id=0)
for number in range(MESSAGES):
    writer.add_message(channel, log_time=number, publish_time=number, data=b"{}")
writer.flush()
# Here its writer is killed: there is no end, and nothing is damaged.
broken_off = stream.getvalue()


def given(messages):
    """How many messages are given before something is raised, and what that is."""
    count, raised = 0, "nothing"
    try:
        for _ in messages():
            count += 1
    except Exception as problem:
        raised = type(problem).__name__
    return count, raised


found = {
    "make_reader": given(lambda: make_reader(io.BytesIO(broken_off)).iter_messages()),
    "NonSeekingReader": given(lambda: NonSeekingReader(io.BytesIO(broken_off)).iter_messages()),
    "NonSeekingReader, order of the file": given(
        lambda: NonSeekingReader(io.BytesIO(broken_off)).iter_messages(log_time_order=False)
    ),
}
for name, (count, raised) in found.items():
    print(f"{name}: {count} of {MESSAGES} messages, raises {raised}")
assert [count for count, _ in found.values()] == [0, 0, MESSAGES], "mcap reads it otherwise now"
PY
"$work/venv/bin/python" "$work/try.py"
