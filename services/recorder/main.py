"""The recorder as a process: writes all that is said of one robot to the disk until a signal, bounded in size."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from services.recorder.topics import everything
from shared.clock import SteadyClock
from shared.loop.config import Misconfigured, OneLineParser, bus_parser, complain, robot_name
from shared.loop.process import StopRequest, told_waiting
from shared.wire.bus import Bus, OnPayload
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError, check_endpoint
from shared.wire.log import SUFFIX, LogWriter
from shared.wire.zenoh import ZenohBus

NAME = "recorder"
TELL, FIRST = 10.0, 2.0  # [s] between two lines of progress, and before the first one
NOTHING = "nothing was heard so far: does a robot of this name run there? See: tandem status"
LEAST, MOST = 8, 1_000_000  # [MB]


def main(arguments: Sequence[str] | None = None) -> int:
    """Record until SIGTERM or SIGINT.

    Returns:
        Exit status: 0 after a signal; with one line on standard error 1 when the disk gave out, 2 after a bad option.
    """
    stop = StopRequest()
    try:
        options = _parser().parse_args(arguments)
        robot = robot_name(options.robot)
        if not LEAST <= options.most <= MOST:
            raise Misconfigured(f"--most {options.most}: wanted {LEAST} to {MOST} MB")
        check_endpoint("--connect", options.connect)
        place: Path = options.out or Path("runs") / f"record-{time.strftime('%Y%m%d-%H%M%S')}"
        place.mkdir(parents=True, exist_ok=True)
        # Of both one recording would be made.
        if there := sorted(place.glob(f"{robot}-*{SUFFIX}")):
            raise Misconfigured(f"--out {place}: {there[0].name} is there already; name another folder")
        _stand_back()
        told = told_waiting(NAME, options.connect, stop)
        with closing(ZenohBus(robot, options.connect, told, credentials=Credentials.of(options.secure))) as bus:
            about = {
                "robot": robot,
                "bus": f"Zenoh, router at {options.connect}",
                "date": time.strftime("%Y-%m-%d %H:%M"),
            }
            log = LogWriter(place / f"{robot}{SUFFIX}", about, options.most * 1_000_000)
            try:
                _record(bus, log, stop, options.camera)
            finally:
                log.close()
    except BusError as problem:
        return 0 if stop.requested else complain(NAME, problem)
    except (Misconfigured, OSError) as problem:
        return complain(NAME, problem)
    _tell(f"{_progress(log)} in {place}")
    if log.problem:
        _tell(f"{log.problem}: what was said since is not recorded")
    return 1 if log.problem else 0


def _parser() -> OneLineParser:
    parser = bus_parser(NAME)
    parser.add_argument("--out", type=Path, help="folder of the recording; default runs/record-<date>")
    parser.add_argument(
        "--most", type=int, default=2000, metavar="MB", help="on the disk; the oldest goes first (default: %(default)s)"
    )
    parser.add_argument(
        "--no-camera",
        dest="camera",
        action="store_false",
        help="no pictures, which are taken only if somebody wants them",
    )
    return parser


def _stand_back() -> None:
    """Whatever else runs goes first: this thread and all that come after it, Zenoh's among them, wait for their turn.

    Not only where nothing else runs at all (SCHED_IDLE): on a full machine nothing would be recorded then.
    """
    os.nice(10)
    if sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def _record(bus: Bus, log: LogWriter, stop: StopRequest, camera: bool) -> None:
    clock = SteadyClock()

    def listener(key: str) -> OnPayload:
        return lambda payload: log.take(key, clock.now_ns(), payload)

    for topic in everything(camera):
        bus.subscribe(topic.key, listener(topic.key))
    _tell("recording; Ctrl-C ends it")
    told = time.monotonic() - TELL + FIRST
    while not stop.requested and not log.problem:
        stop.wake.wait(0.2)
        if time.monotonic() - told > TELL:
            told = time.monotonic()
            _tell(_progress(log))


def _progress(log: LogWriter) -> str:
    heard = f"{log.heard:,} messages, {log.written / 1e6:.1f} MB" if log.heard else NOTHING
    return heard + (f", {log.lost:,} were lost since the disk is too slow" if log.lost else "")


def _tell(line: str) -> None:
    print(f"{NAME}: {line}", file=sys.stderr, flush=True)
