"""Makes the golden recordings: services that hear a robot, in simulated time, and all that they take and say."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterable
from functools import partial
from pathlib import Path

import cv2
import msgpack
import numpy as np

from services.experiment.replay.recorded import outputs
from services.experiment.replay.subjects import SUBJECTS
from shared.loop.runner import Runner
from shared.loop.stack import Stack
from shared.topics import setup_topic
from shared.wire.log import Heard, write_log
from tests.replay.cases import HERE, Case, cases
from tests.replay.events import LATENCY_NS, Event, events

RECORDINGS = HERE / "recordings"
CAMERA = "sensor/camera"
HEARD = (
    "sensor/ft",
    CAMERA,
    "state/ee",
    "state/gripper",
    "state/robot",
    "stop",
    "control/target",
)
"""What the services take of others."""
THINNED = ("command/ee_twist", "command/base_twist", "base/status")
"""What no other service takes: every tenth of it is kept."""
SESSION = 1000
"""Stands for every session of the robot, which are drawn at random."""
_BITS = 16  # behind the point of a number in SI units that a robot's sensor gives, so that a file stays small
_POSES = 3  # of so many poses of the tool one is kept


def record() -> None:
    """Play the runs in the simulation, then make every recording from what the robot said in them."""
    # Only here: it needs the simulation, which a replay does without.
    from benchmarks.experiment_stack import play_run
    from tests.replay.robots import ROBOTS

    with tempfile.TemporaryDirectory() as name:
        for robot, (experiment, run) in ROBOTS.items():
            play_run(experiment, run, path=Path(name) / f"{robot}.mcap")
        make({robot: list(kept(events(Path(name) / f"{robot}.mcap", HEARD))) for robot in ROBOTS})


def make(robots: dict[str, list[Event]]) -> None:
    """Make every recording from what robots said, by the names of their runs."""
    RECORDINGS.mkdir(exist_ok=True)
    for case in cases():
        write(case, case.edited(said_by_others(case, robots[case.robot])))


def expect() -> None:
    """Take the present answers for right: every recording anew, from what it has of the robot and of people."""
    for case in cases():
        write(case, said_by_others(case, events(_path(case), HEARD)))


def said_by_others(case: Case, said: Iterable[Event]) -> list[Event]:
    """What none of the case's services says itself."""
    own = {topic.key for name in case.services for topic in outputs(name)} - {"stop"}
    return [event for event in said if event.key not in own]


def write(case: Case, given: Iterable[Event]) -> None:
    """Let the services of a case hear events, and record."""
    with tempfile.TemporaryDirectory() as name:
        heard = _Staged(case, Path(name)).heard(given)
    path = _path(case)
    write_log(path, {"robot": "tiago", "case": case.name}, _thinned(heard))
    print(f"{path.name}: {path.stat().st_size:,} bytes")


def kept(said: Iterable[Event]) -> Iterable[Event]:
    """What a robot said, in fewer bytes: numbers rounded, every third pose, pictures grey and without their noise."""
    for event in said:
        content = event.content if event.asked else {**event.content, "session": SESSION}
        if event.key == "state/ee":
            if content["seq"] % _POSES:
                continue
            content["seq"] //= _POSES
        if event.key == CAMERA:
            content["data"] = _smaller(content["data"])
        elif event.key in ("sensor/ft", "state/ee"):
            content = {name: _rounded(value) for name, value in content.items()}
        yield Event(event.time, event.key, content, event.asked)


def _rounded(value: object) -> object:
    if isinstance(value, list):
        return [round(number * 2**_BITS) / 2**_BITS for number in value]
    return value


def _smaller(picture: bytes) -> bytes:
    grey = cv2.imdecode(np.frombuffer(picture, dtype=np.uint8), cv2.IMREAD_GRAYSCALE)
    _, smaller = cv2.imencode(".jpg", cv2.GaussianBlur(grey, (3, 3), 0), (cv2.IMWRITE_JPEG_QUALITY, 30))
    return smaller.tobytes()


def _path(case: Case) -> Path:
    return RECORDINGS / f"{case.name}.mcap"


def _thinned(heard: Iterable[Heard]) -> Iterable[Heard]:
    count = dict.fromkeys(THINNED, 0)
    for one in heard:
        if one.key in THINNED:
            count[one.key] += 1
            if count[one.key] % 10 != 1:
                continue
        yield one


class _Staged:
    """The services of a case in a folder of their own, on a bus of which everything is heard."""

    def __init__(self, case: Case, folder: Path) -> None:
        self._case, self._folder = case, folder
        self._stack = Stack(LATENCY_NS * 1e-9)
        self._heard: list[Heard] = []
        self._runners: dict[str, Runner] = {}
        # A payload's file is copied: an identification would write to it.
        shutil.copy(HERE / "payload.toml", folder)
        said = {topic.key for name in case.services for topic in outputs(name)}
        own = {setup_topic(name).key for name in case.services}
        for key in sorted({*HEARD, *said, *own} - {CAMERA}):
            self._stack.bus.subscribe(key, partial(self._hear, key))
        for name in case.services:
            self._start(name)

    def heard(self, given: Iterable[Event]) -> list[Heard]:
        """Lets the whole case pass."""
        scheduler = self._stack.scheduler
        for event in given:
            scheduler.at(event.time, partial(self._put, event))
        for time, service in self._case.restarts:
            scheduler.at(time, partial(self._start, service))
        scheduler.run_until(round(self._case.end * 1e9))
        return self._heard

    def _start(self, name: str) -> None:
        """Start a service; one that runs already is killed before."""
        if name in self._runners:
            self._stack.kill(self._runners[name])
        settings = {
            key: value.replace("FOLDER", str(self._folder)) if isinstance(value, str) else value
            for key, value in self._case.services[name].items()
        }
        service = SUBJECTS[name]((settings, settings.keys()), self._folder, lambda: self._stack.now)
        self._runners[name] = self._stack.add(service)

    def _put(self, event: Event) -> None:
        payload = msgpack.packb(event.content)
        if event.key == CAMERA and self._stack.bus.wanted(CAMERA):
            # Listening there would be heard, too: pictures are taken for those who look.
            self._stack.scheduler.at(event.time + LATENCY_NS, partial(self._hear, CAMERA, payload))
        if not event.asked:
            self._stack.bus.publish(event.key, payload)
        elif not self._stack.bus.query_later(event.key, payload, lambda reply: None):
            raise LookupError(f"{self._case.name}: nobody serves {event.key}")

    def _hear(self, key: str, payload: bytes) -> None:
        self._heard.append(Heard(key, self._stack.scheduler.clock.now_ns(), bytes(payload)))
