#!/usr/bin/env bash
# rosbags 0.11.9 (Python): an array of numbers of another type than the field's is written as it lies in memory.
#
# Expected: the numbers are converted, or the message is refused.
# Found: `serialize_cdr` copies the bytes of the array. Integers 1 and 2 in a float64[] are 5e-324 and 1e-323 for whoever
# reads them, and nothing is raised. It is for the size alone that float32 fails, with a ValueError.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --disable-pip-version-check -q rosbags==0.11.9
cat > "$work/try.py" <<'PY'
import numpy as np
from rosbags.typesys import Stores, get_typestore

KIND = "std_msgs/msg/Float64MultiArray"
store = get_typestore(Stores.ROS2_HUMBLE)
layout = store.types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)


def read_back(values):
    """What a reader gets of an array."""
    message = store.types[KIND](layout=layout, data=values)
    try:
        payload = bytes(store.serialize_cdr(message, KIND))
        return store.deserialize_cdr(payload, KIND).data.tolist()
    except Exception as problem:
        return f"raises {type(problem).__name__}"


found = {dtype: read_back(np.array([1, 2], dtype=dtype)) for dtype in ("float64", "int64", "float32")}
for dtype, values in found.items():
    print(f"[1, 2] as {dtype}: read as {values}")
assert found["float64"] == [1.0, 2.0] and found["int64"] == [5e-324, 1e-323], "rosbags converts now"
PY
"$work/venv/bin/python" "$work/try.py"
