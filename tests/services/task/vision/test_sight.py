"""What is said of a camera whose pictures are of no use is not what is said of a frozen one."""

from __future__ import annotations

import numpy as np
import pytest

from services.task.parameters import TaskParameters
from services.task.vision.sight import Sight
from shared.messages import CameraImage, EndEffector, Header
from shared.service import Reading
from shared.spatial import quaternion_from_rpy

LEVEL = (0.0, 0.0, 0.0, 1.0)
TOOL = EndEffector((0.5, -0.3, 0.8), LEVEL, (0.0,) * 3, (0.0,) * 3)
SIZE = (640, 480)
COUNT = SIZE[0] * SIZE[1]


@pytest.mark.parametrize(
    ("encoding", "data", "said"),
    [
        ("rgb8", b"", "camera_broken"),
        ("mono8", bytes(7), "camera_broken"),
        ("jpeg", b"nothing", "camera_broken"),
        ("mono8", bytes(COUNT), "camera_blank"),
        ("mono8", bytes(np.tile(np.arange(256, dtype=np.uint8), COUNT // 256)), "camera_frozen"),
    ],
)
def test_each_cause_has_its_sentence_while_the_head_turns(encoding: str, data: bytes, said: str) -> None:
    sight = Sight(TaskParameters())
    for number in range(30):
        turned = quaternion_from_rpy(-1.9, 0.0, -1.6 + 0.02 * number)
        image = CameraImage(*SIZE, encoding, data, (525.0, 525.0, 320.0, 240.0), (), (0.1, 0.0, 1.1), turned)
        header = Header(number, 1, number * 100_000_000, True)
        sight.advance(0.1)
        sight.look(Reading(image, header, 0.0, True), Reading(TOOL, header, 0.0, True))
    assert sight.doubt is not None
    assert sight.doubt.name == said, sight.doubt.sentence
