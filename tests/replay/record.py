"""Makes the recordings: the simulation and the experiment's tool in a whole stack, heard in simulated time."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import cv2
import msgpack
import numpy as np

from benchmarks.experiment_stack import LONGEST, Staged
from services.experiment.carry import carry_protocol as carry
from services.experiment.carry.carry import CARRY
from services.experiment.load.load import LOAD
from services.experiment.play.course import Run
from services.experiment.spec import Experiment
from tests.replay import recordings
from tests.replay.recordings import Event

KEYS = ("sensor/ft", "sensor/camera", "state/ee", "state/gripper", "state/robot", "stop")
"""What one of the replayed services subscribes to; nobody of them hears ``state/joints`` and ``state/base``."""
SESSION = 1000
"""Stands for every session, which are drawn at random."""
CAMERA_RATE = 3.0  # [Hz]: pictures are what takes most room
QUALITY = 30  # [%] of a picture as it is kept: grey, its noise smoothed


def record(folder: Path) -> None:
    """Write both recordings."""
    settings = carry.run("certified", "omni").settings
    run = replace(
        carry.run("certified", "omni"), settings={**settings, "sim": {**settings["sim"], "camera_rate": CAMERA_RATE}}
    )
    recordings.save(folder / "carry.xz", heard(CARRY, run, KEYS))
    certified = LOAD.run_named("certified-100")
    recordings.save(folder / "load.xz", heard(LOAD, certified, (*KEYS, "control/target")))


def heard(experiment: Experiment, run: Run, keys: tuple[str, ...]) -> list[Event]:
    """What is put on the bus under some keys, and what is asked, while a run is played."""
    events: list[Event] = []
    with tempfile.TemporaryDirectory() as name:
        staged = Staged(partial(experiment.player, run), run, Path(name))
        bus, clock = staged.stack.bus, staged.stack.scheduler.clock
        publish, ask = bus.publish, bus.query_later

        # Subscribing would be heard, too: a camera takes no pictures that nobody wants.
        def publish_and_note(key: str, payload: bytes) -> None:
            if key in keys:
                events.append(Event(clock.now_ns(), key, _kept(msgpack.unpackb(payload))))
            publish(key, payload)

        def ask_and_note(key: str, payload: bytes, on_reply) -> bool:  # type: ignore[no-untyped-def]
            if not key.startswith("sim/"):
                events.append(Event(clock.now_ns(), key, msgpack.unpackb(payload), asked=True))
            return ask(key, payload, on_reply)

        bus.publish, bus.query_later = publish_and_note, ask_and_note  # type: ignore[method-assign]
        staged.stack.run(LONGEST, done=lambda: staged.player.finished)
    if not staged.player.finished:
        raise TimeoutError(f"{run.name} did not end within {LONGEST:g} s of simulated time")
    return events


def _kept(content: dict) -> dict:
    if content.get("encoding") != "jpeg":
        return {**content, "session": SESSION}
    grey = cv2.imdecode(np.frombuffer(content["data"], dtype=np.uint8), cv2.IMREAD_GRAYSCALE)
    _, smaller = cv2.imencode(".jpg", cv2.GaussianBlur(grey, (3, 3), 0), (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
    return {**content, "session": SESSION, "data": smaller.tobytes()}
