"""Which marker poses are believed, without any image."""

from __future__ import annotations

import numpy as np
import pytest

from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.vision.marker_tracker import Candidate, MarkerTracker, Solution
from shared.spatial import rotation_from_vector

SETTINGS = TaskParameters()
CORNERS = np.zeros((4, 2))
ORIGIN = Pose(np.zeros(3), np.eye(3))


def seen(x: float = 0.0, error: float = 0.1, other: float = 1.0, turn: float = 0.5, number: int = 7) -> Candidate:
    first = Solution(np.array((x, 0.0, 1.0)), np.eye(3), error)
    second = Solution(np.array((x, 0.0, 1.0)), rotation_from_vector((turn, 0.0, 0.0)), other)
    return Candidate(number, (first, second), CORNERS)


def tracker(images: int = 3) -> MarkerTracker:
    made = MarkerTracker(SETTINGS)
    for _ in range(images):
        made.advance(0.1)
        made.look([seen()], ORIGIN, 0.0)
    return made


def doubt(made: MarkerTracker) -> str:
    assert made.pose is None
    return made.doubt.name


def test_it_takes_three_images() -> None:
    assert doubt(tracker(0)) == "camera_never"
    assert doubt(tracker(2)) == "marker_new"
    made = tracker(3)
    assert made.pose is not None and made.doubt is None


@pytest.mark.parametrize(
    ("candidate", "name"),
    [
        (seen(number=8), "marker_other"),
        (seen(error=0.7, other=9.0), "marker_error"),
        (seen(error=0.1, other=0.2), "marker_ambiguous"),
        (Candidate(7, (), CORNERS), "marker_edges"),
    ],
)
def test_doubtful_ones_are_refused(candidate: Candidate, name: str) -> None:
    made = tracker(0)
    made.look([candidate], ORIGIN, 0.0)
    assert doubt(made) == name
    assert made.doubt.sentence


def test_two_good_fits_are_told_apart_by_what_corners_can_be_measured_to() -> None:
    """Ratios of errors that are both noise say nothing: 0.001 px is no worse than 0.0001 px, and 0.4 px is than 0.1."""
    for best, other, clear in ((0.0001, 0.001, False), (0.2, 0.21, False), (0.1, 0.4, True), (0.0, 0.19, True)):
        made = MarkerTracker(TaskParameters(marker_confirm=1, marker_accuracy=0.1))
        made.look([seen(error=best, other=other)], ORIGIN, 0.0)
        assert (made.pose is not None) == clear, (best, other)


def test_a_jump_is_refused_and_the_pose_stays_until_it_is_old() -> None:
    made = tracker()
    before = made.pose
    made.advance(0.1)
    made.look([seen(x=0.2)], ORIGIN, 0.0)
    assert made.pose is before
    for _ in range(5):
        made.advance(0.1)
        made.look([seen(x=0.2)], ORIGIN, 0.0)
    # The old one is forgotten; the panel was really moved, and is found again by as many images as at first.
    assert made.pose is None
    for _ in range(3):
        made.advance(0.1)
        made.look([seen(x=0.2)], ORIGIN, 0.0)
    assert made.pose.position[0] == pytest.approx(0.2)


def test_one_outlier_among_good_ones_changes_nothing() -> None:
    made = tracker()
    for x in (0.3, 0.0, -0.4, 0.0):
        made.advance(0.1)
        made.look([seen(x=x)], ORIGIN, 0.0)
        assert made.pose.position[0] == pytest.approx(0.0)


def test_no_pose_is_older_than_allowed() -> None:
    made = tracker()
    made.advance(0.45)
    assert made.pose is not None and made.age == pytest.approx(0.45)
    made.advance(0.1)
    assert doubt(made) == "camera_silent"


def test_a_camera_slower_than_a_pose_may_be_old_is_called_slow_until_it_is_silent() -> None:
    made = tracker()
    for _ in range(3):
        made.advance(1.0)
        made.look([seen()], ORIGIN, 0.0)
        made.advance(0.6)
        assert doubt(made) == "camera_slow" and "1.0 s apart" in made.doubt.sentence
        made.advance(-0.6)
    made.advance(2.1)
    assert doubt(made) == "camera_silent"


def test_an_old_image_is_refused() -> None:
    made = tracker(0)
    made.look([seen()], ORIGIN, 0.6)
    assert doubt(made) == "marker_old" and "0.60 s old" in made.doubt.sentence


def test_covered_for_longer_than_allowed() -> None:
    made = tracker()
    for _ in range(6):
        made.advance(0.1)
        made.look([], ORIGIN, 0.0)
    assert doubt(made) == "marker_missing"


def test_smoothing_follows_slow_motion() -> None:
    made = tracker()
    for step in range(100):
        made.advance(0.1)
        made.look([seen(x=0.001 * step)], ORIGIN, 0.0)
    assert made.pose.position[0] == pytest.approx(0.099, abs=0.005)
