"""Rerun's viewer without a window: pictures of a drawing at chosen times."""

from __future__ import annotations

import io
import os
import re
import subprocess
import tempfile
import time
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Self, TypeVar

import imageio.v2 as imageio
import numpy as np
from numpy.typing import NDArray

from services.viewer.page import rerun_files
from services.viewer.stream import free
from shared.clock import nanoseconds
from shared.loop.config import Misconfigured
from shared.loop.tether import tethered

if TYPE_CHECKING:
    from rerun.experimental import ViewerClient

T = TypeVar("T")
Picture = NDArray[np.uint8]

READY_WITHIN, PICTURE_WITHIN, ENDS_WITHIN = 120.0, 60.0, 2.0  # [s], on a busy machine
_AGAIN = 0.1  # [s] between two questions whether it is ready
_BAR = 36  # [px] that the window's own bar takes on top, empty as it is
_PANIC = re.compile(r"panicked at '?(.*?)'?$", re.MULTILINE)
_REMEDY = "it needs a driver of Vulkan, as that of the processor: apt-get install mesa-vulkan-drivers"


class Windowless:
    """A viewer of a drawing that is served; a context manager that ends it.

    Args:
        source: address of the drawing.
        size: of the pictures, width and height [px].
        end: newest time [s] of the drawing: it is ready once it has that.

    Raises:
        Misconfigured: it does not start, or gets no drawing.
    """

    def __init__(self, source: str, size: tuple[int, int], end: float) -> None:
        try:
            program = rerun_files.program()
        except rerun_files.Missing as problem:
            raise Misconfigured(str(problem)) from None
        port = free("127.0.0.1", 0)
        command = [str(program), source, "--headless", "--hide-welcome-screen", "--bind", "127.0.0.1"]
        command += ["--port", str(port), "--window-size", f"{size[0]}x{size[1] + _BAR}"]
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 closed by close()
        # Mesa compiles its shaders anew for each picture where it may not keep them, as in a container's home.
        self._kept = tempfile.TemporaryDirectory()
        # With CI it reports nothing to its makers; what it warns of would stand in its pictures.
        self._process = subprocess.Popen(
            tethered(command),
            stdin=subprocess.DEVNULL,
            stdout=self._said,
            stderr=self._said,
            env={**os.environ, "CI": "1", "RUST_LOG": "error", "MESA_SHADER_CACHE_DIR": self._kept.name},
            process_group=0,
        )
        try:
            self._viewer = self._ask(lambda: _connected(port), READY_WITHIN)
            self._await(end)
        except BaseException:
            self.close()
            raise

    def picture(self, time: float) -> Picture:
        """What it shows at a time [s] of the drawing (height, width, 3): red, green, blue.

        It answers one question after the other, that for a picture with the first one that it paints afterwards.

        Raises:
            Misconfigured: it has ended, or does not answer.
        """
        moment = np.timedelta64(nanoseconds(time), "ns")
        self._ask(lambda: self._viewer.set_time("time", duration=moment, play_state="paused"), PICTURE_WITHIN)
        shot = self._ask(self._viewer.take_screenshot, PICTURE_WITHIN)
        picture: Picture = imageio.imread(io.BytesIO(shot))[_BAR:, :, :3]
        return picture

    def _await(self, end: float) -> None:
        deadline = time.monotonic() + READY_WITHIN
        while time.monotonic() < deadline:
            for recording in self._ask(self._viewer.get_state, READY_WITHIN).recordings:
                if any((line.end or 0) >= nanoseconds(end) for line in recording.timelines):
                    return
            time.sleep(_AGAIN)
        raise Misconfigured(f"rerun's viewer has not taken in the drawing within {READY_WITHIN:.0f} s")

    def _ask(self, question: Callable[[], T], within: float) -> T:
        """The viewer's answer; it may be busy for longer than a question waits."""
        deadline = time.monotonic() + within
        while True:
            try:
                return question()
            except (ConnectionError, TimeoutError) as problem:
                if self._process.poll() is not None:
                    raise Misconfigured(self._how_it_ended()) from None
                if time.monotonic() > deadline:
                    raise Misconfigured(f"rerun's viewer does not answer: {str(problem).splitlines()[0]}") from None
                time.sleep(_AGAIN)

    def _how_it_ended(self) -> str:
        self._said.seek(0)
        found = _PANIC.search(self._said.read().decode(errors="replace"))
        cause = f": {found[1]}; {_REMEDY}" if found else ""
        return f"rerun's viewer ended with status {self._process.returncode}{cause}"

    def close(self) -> None:
        """End it."""
        self._process.terminate()
        try:
            self._process.wait(ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._said.close()
        self._kept.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _connected(port: int) -> ViewerClient:
    from rerun.experimental import ViewerClient

    return ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
