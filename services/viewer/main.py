"""The viewer as a process: draws what is said of one robot for browsers on this machine until a signal."""

from __future__ import annotations

import math
import os
import shutil
import sys
import tempfile
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from services.viewer.blueprint import SIDES, side_by_side
from services.viewer.draw.drawing import PERIOD, Drawing
from services.viewer.heard import WATCHED, Ears
from services.viewer.looking import looked_at
from services.viewer.page.server import HEARD_WITHIN, recorded_page, served
from services.viewer.recorded import draw
from services.viewer.stream import Stream
from shared.clock import SteadyClock
from shared.loop.config import Misconfigured, OneLineParser, bus_parser, complain, robot_name
from shared.loop.healthy import tell
from shared.loop.process import StopRequest, told_waiting
from shared.topics import HEALTH_RATE
from shared.wire.bus import Bus, Leave
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError, check_endpoint
from shared.wire.log import NoRecording, recordings
from shared.wire.zenoh import ZenohBus

NAME = "viewer"
SELDOM = 5.0  # [Hz]: what comes no more often is listened to even while nobody looks
ROOM = 1_000_000  # [bytes] that are left on a disk to which all could be written
TELL = 2.0  # [s] between two words of how much of a recording is drawn


def main(arguments: Sequence[str] | None = None) -> int:
    """Show until SIGTERM or SIGINT.

    Returns:
        Exit status: 0 after a signal; 2 with one line on standard error after a bad option or a taken port.
    """
    stop = StopRequest()
    try:
        options = _parser().parse_args(arguments)
        if options.recording is not None:
            return _show_recording(options, stop)
        robot = robot_name(options.robot)
        check_endpoint("--connect", options.connect)
        credentials = Credentials.of(options.secure, robot)
        with Stream.served("127.0.0.1", options.stream_port) as stream:
            told = told_waiting(NAME, options.connect, stop)
            with closing(ZenohBus(robot, options.connect, told, credentials=credentials)) as bus:
                ears = Ears(clock := SteadyClock(), clock.now_ns())
                page = served(options.listen, options.port, stream.uri, ears, bus, robot, credentials)
                with closing(page), looked_at(page.url, stream.uri, options.open, options.native) as seen:
                    _tell(f"{page.url}; Ctrl-C ends it")
                    watched = (lambda: True) if options.native else (lambda: page.watched)
                    _show(bus, Drawing(stream.rec, ears), ears, stop, options.connect, seen, watched)
    except BusError as problem:
        return 0 if stop.requested else complain(NAME, problem)
    except (Misconfigured, NoRecording, OSError) as problem:
        return complain(NAME, problem)
    return 0


def _parser() -> OneLineParser:
    parser = bus_parser(NAME)
    parser.add_argument(
        "--listen", default="127.0.0.1", metavar="ADDRESS", help="who reaches the page (default: %(default)s)"
    )
    parser.add_argument(
        "--port",
        type=int,
        default=9090,
        help="of the page, and one above of its picture; 0: any (default: %(default)s)",
    )
    parser.add_argument(
        "--recording",
        type=Path,
        metavar="PATH",
        help="show a recording (.mcap), or all in a folder, instead of a robot",
    )
    parser.add_argument("--beside", type=Path, metavar="PATH", help="with --recording: another one on its right")
    parser.add_argument("--open", action="store_true", help="open the page, where there is a desktop")
    parser.add_argument("--native", action="store_true", help="in rerun's own viewer, too; all ends with its window")
    parser.add_argument(
        "--stream-port", type=int, default=0, help="on loopback, for rerun's own viewer; 0: any (default: %(default)s)"
    )
    return parser


def _show(
    bus: Bus,
    drawing: Drawing,
    ears: Ears,
    stop: StopRequest,
    connect: str,
    seen: Callable[[], bool],
    watched: Callable[[], bool],
) -> None:
    """Listen and draw for as long as nothing ends it; to what comes often while somebody looks only.

    What is said to somebody outside the chain costs its processes and the router, too, and a picture has to be taken.
    """
    for topic in WATCHED:
        if topic.rate <= SELDOM:
            bus.subscribe(topic.key, ears.subscriptions[topic.key].offer)
    often = [topic.key for topic in WATCHED if topic.rate > SELDOM]
    leaves: list[Leave] = []
    since = 0.0
    # Whatever else runs goes first; the page's threads are there already and keep their turn: STOP does not wait.
    os.nice(10)
    told = -math.inf
    while not stop.requested and seen():
        cut_off = "" if bus.connected() else f"no router at {connect}"
        if watched():
            if not leaves:
                leaves, since = [bus.listen(key, ears.subscriptions[key].offer) for key in often], time.monotonic()
            # Before, the sentence would tell of silence.
            if time.monotonic() - since > HEARD_WITHIN:
                drawing.advance(cut_off)
        elif leaves:
            for leave in leaves:
                leave()
            leaves = []
            for key in often:
                ears.forget(key)
        if time.monotonic() - told > 1.0 / HEALTH_RATE:
            told = time.monotonic()
            tell("degraded" if cut_off else "ok", cut_off)
        stop.wake.wait(PERIOD)


def _show_recording(options: Namespace, stop: StopRequest) -> int:
    """Draw a recording into a file, which is forgotten at the end, and serve that; nothing else is needed."""
    places: list[Path] = [options.recording, *([options.beside] if options.beside else [])]
    shown = {place: recordings(place) for place in places}
    names = " beside ".join(map(str, places))
    os.nice(10)
    with tempfile.TemporaryDirectory(prefix="tandem-view-") as folder:
        path = Path(folder) / "run.rrd"
        _tell(f"drawing {names}")
        with Stream.written(path, side_by_side([str(place) for place in places]) if options.beside else None) as stream:
            lasts = max(
                draw(stream.rec, shown[place], _goes_on(place, stop), side)
                for place, side in zip(places, SIDES, strict=False)
            )
        if stop.requested:
            return 0
        check_room(Path(folder))
        page = recorded_page(options.listen, options.port, path, f"a recording: {names}, {lasts:.0f} s")
        with closing(page), looked_at(page.url, str(path), options.open, options.native) as seen:
            _tell(f"{page.url}; Ctrl-C ends it")
            while not stop.requested and seen():
                stop.wake.wait(0.2)
    return 0


def check_room(folder: Path) -> None:
    """Rerun says nothing when the disk that it writes to is full.

    Raises:
        Misconfigured: it is.
    """
    if shutil.disk_usage(folder).free < ROOM:
        raise Misconfigured(f"{folder.parent}: the disk is full, so not all is drawn; make room, or set TMPDIR")


def _goes_on(place: Path, stop: StopRequest) -> Callable[[float], bool]:
    """Says now and then how much is drawn [s]; the drawing goes on until a signal."""
    told = time.monotonic()

    def goes_on(drawn: float) -> bool:
        nonlocal told
        if time.monotonic() - told > TELL:
            told = time.monotonic()
            _tell(f"{drawn:.0f} s of {place} are drawn")
        return not stop.requested

    return goes_on


def _tell(line: str) -> None:
    print(f"{NAME}: {line}", file=sys.stderr, flush=True)
