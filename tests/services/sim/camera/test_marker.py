"""The marker on the panel: OpenCV's dictionary, drawn as strips."""

from __future__ import annotations

import numpy as np
import pytest

from services.sim.camera import marker


def test_the_dictionary_has_fifty_markers_that_no_turn_confuses() -> None:
    seen = set()
    for identity in range(50):
        cells = marker.black(identity)
        assert cells[0].all() and cells[-1].all() and cells[:, 0].all() and cells[:, -1].all()
        turns = {np.rot90(cells, quarter).tobytes() for quarter in range(4)}
        assert len(turns) == 4 and not turns & seen
        seen |= turns
    # OpenCV's marker 0, row by row: 1011 0101 0011 0010.
    assert (~marker.black(0)[1:-1, 1:-1]).astype(int).tolist() == [
        [1, 0, 1, 1],
        [0, 1, 0, 1],
        [0, 0, 1, 1],
        [0, 0, 1, 0],
    ]


@pytest.mark.parametrize("identity", [0, 7, 23])
def test_the_black_strips_are_the_black_cells(identity: int) -> None:
    cells = np.zeros((6, 6), dtype=bool)
    for left, right, lower, upper in marker.strips(identity):
        cells[round(3 - upper) : round(3 - lower), round(left + 3) : round(right + 3)] = True
    assert (cells == marker.black(identity)).all()
