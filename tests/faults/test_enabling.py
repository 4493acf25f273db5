"""An enabling device on a topic of the robot's own: what is let go, or falls silent, leaves the arm at rest.

Over rmw_zenoh, with processes, seen by the robot's samples.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from shared.robot.profile import PROFILES
from tests.conftest import Router, StartProcess
from tests.faults import test_bridge_ros2
from tests.faults.test_bridge_ros2 import ARM_WITHIN, SAMPLE, last_motion
from tests.services.bridge_ros2.far import FarNetwork
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.slow]
MAX_AGE = 0.2  # [s] after which a silent device counts as let go
TOLD = 1.5  # [s] for which the robot is looked at afterwards
EVERY = 0.02  # [s] between two words of the device


def with_device(folder: Path, profile: str, kind: str) -> str:
    """Path of a shipped profile that has an enabling device besides."""
    path = folder / "mine.toml"
    shipped = PROFILES / f"{profile}.toml"
    path.write_text(f'{shipped.read_text()}\n[enable]\ntopic = "/device"\ntype = "{kind}"\nbutton = 1\n')
    return str(path)


class Device:
    """Tells again and again whether it is pressed, in a thread of its own; nothing while ``pressed`` is None."""

    def __init__(self, tell: Callable[[bool], None]) -> None:
        self.pressed: bool | None = False
        self._tell, self._end = tell, threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        while not self._end.wait(EVERY):
            if self.pressed is not None:
                self._tell(self.pressed)

    @contextmanager
    def plugged(self) -> Iterator[None]:
        self._thread.start()
        try:
            yield
        finally:
            self._end.set()
            self._thread.join()


def let_go(device: Device, speeds: Callable[[], list[float]], pressed: bool | None, within: float) -> None:
    """The device says that it is let go, or nothing any more: the arm rests in time, and stays so."""
    device.pressed, begun = pressed, len(speeds())
    eventually(lambda: len(speeds()) - begun > TOLD / SAMPLE, 60.0, "the robot tells on")
    after = speeds()[begun:]
    took = last_motion(after)
    print(f"{'let go' if pressed is False else 'silent'}: arm at rest after {took:.2f} s")
    assert took < within + SAMPLE


def both_ways(device: Device, set_off: Callable[[], None], speeds: Callable[[], list[float]]) -> None:
    """Neither moves on; and pressed again it goes on, since nobody has to release a stop."""
    for pressed, within in ((False, ARM_WITHIN), (None, ARM_WITHIN + MAX_AGE)):
        device.pressed = True
        set_off()
        let_go(device, speeds, pressed, within)


def test_a_button_of_ros_2(start: StartProcess, router: Router, tmp_path: Path) -> None:
    mine = (f'--set=profile="{with_device(tmp_path, "tiago-ros2", "std_msgs/msg/Bool")}"',)
    scene = test_bridge_ros2.Scene(router.endpoint, start, its=mine)
    pad = FarNetwork(scene.far, "rmw_zenoh")
    try:
        pad.advertise("/device", "std_msgs/msg/Bool")
        # A Bool in CDR, little endian.
        device = Device(lambda pressed: pad.publish("/device", bytes((0, 1, 0, 0, pressed))))
        with scene.around, device.plugged():
            both_ways(device, scene.moves, lambda: [sample.speed for sample in scene.witness.arm])
    finally:
        pad.close()
        scene.witness.close()
