"""The film of the load experiment.

The recording holds ``time`` (N,) [s], ``joint_names`` (n,), ``joint_positions`` (N, n) [m, rad], ``bag_mass`` (N,)
[kg], ``bag_height`` (N,) [m], ``force_z`` (N,) [N] as measured at the tool, and ``limit_z`` [N], one number or (N,).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from services.sim.camera.canvas import Picture
from services.sim.film.load_scene import Scene
from shared.loop.config import Misconfigured
from shared.spatial import Array

WIDTH, HEIGHT = 640, 480
OVERSAMPLING = 1.5
"""The renderer draws hard edges; a larger picture made smaller has soft ones."""
_INK, _PALE, _CALM, _OVER = (40, 44, 52), (214, 217, 222), (46, 125, 90), (200, 60, 45)
_SMOOTHING = 0.1
"""Time [s] over which the force on the scale is averaged, so that it can be read."""


@dataclass(frozen=True)
class LoadRun:
    """A recorded run, sampled at common times (N,)."""

    time: Array
    joint_names: tuple[str, ...]
    joint_positions: Array
    bag_mass: Array
    bag_height: Array
    force_z: Array
    limit_z: Array

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> LoadRun:
        """Take over a recording.

        Raises:
            Misconfigured: if it does not hold what a film needs; one line.
        """
        columns = {name: data[name] for name in cls.__dataclass_fields__}
        names = tuple(str(name) for name in columns.pop("joint_names"))
        rows = len(columns["time"])
        columns["limit_z"] = np.broadcast_to(columns["limit_z"], rows)
        if rows < 2 or any(len(column) != rows for column in columns.values()):
            lengths = ", ".join(f"{name} {len(column)}" for name, column in columns.items())
            raise Misconfigured(f"wanted series of one length, at least 2, got {lengths}")
        if columns["joint_positions"].shape != (rows, len(names)):
            shape = columns["joint_positions"].shape
            raise Misconfigured(f"joint_positions has shape {shape}, wanted {(rows, len(names))}")
        return cls(joint_names=names, **columns)

    def row(self, time: float) -> int:
        """Row of the newest sample at a time [s]."""
        return max(0, int(np.searchsorted(self.time, time, side="right")) - 1)

    def load_on_tool(self, time: float) -> float:
        """Downward force [N] at the tool, averaged over the last instants."""
        rows = slice(self.row(time - _SMOOTHING), self.row(time) + 1)
        return float(-np.nanmean(self.force_z[rows]))


def frames(run: LoadRun, rate: float, speed: float) -> Iterator[Picture]:
    """Pictures (HEIGHT, WIDTH, 3) of a run at ``rate`` [1/s of film], ``speed`` times as fast as it happened."""
    scene = Scene(round(WIDTH * OVERSAMPLING), round(HEIGHT * OVERSAMPLING))
    scale = _Scale(float(np.nanmax(np.abs(run.limit_z))), speed)
    try:
        for time in np.arange(run.time[0], run.time[-1], speed / rate):
            row = run.row(time)
            hangs = run.bag_mass[row] > 0.0 and np.isfinite(run.bag_height[row])
            joints = dict(zip(run.joint_names, run.joint_positions[row].tolist(), strict=True))
            scene.pose(joints, float(run.bag_height[row]) if hangs else None)
            picture = Image.fromarray(scene.picture()).resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
            scale.draw(picture, time - run.time[0], run.load_on_tool(time), float(run.limit_z[row]))
            column, line = scene.pixel(scene.tool())
            _arrow(picture, column / OVERSAMPLING, line / OVERSAMPLING, run.load_on_tool(time))
            yield np.asarray(picture)
    finally:
        scene.close()


class _Scale:
    """A vertical scale of the load with its limit, and the time."""

    def __init__(self, limit: float, speed: float) -> None:
        self._full = 1.6 * limit
        self._speed = speed
        self._font = ImageFont.load_default(15)
        self._large = ImageFont.load_default(20)

    def draw(self, picture: Image.Image, time: float, load: float, limit: float) -> None:
        pen = ImageDraw.Draw(picture)
        left, right, top, bottom = WIDTH - 74, WIDTH - 50, 70, HEIGHT - 60
        level = bottom - (bottom - top) * min(max(load / self._full, 0.0), 1.0)
        mark = bottom - (bottom - top) * limit / self._full
        pen.rectangle((left, top, right, bottom), fill=(246, 247, 249), outline=_PALE, width=2)
        colour = _OVER if load > limit else _CALM
        pen.rectangle((left + 2, min(level, bottom - 2), right - 2, bottom - 2), fill=colour)
        pen.line((left - 10, mark, right + 10, mark), fill=_INK, width=2)
        pen.text((left - 14, mark), f"limit {limit:.0f} N", _INK, self._font, anchor="rm")
        pen.text(((left + right) / 2, top - 12), f"{load:.1f} N", _INK, self._large, anchor="mb")
        pen.text(((left + right) / 2, bottom + 10), "load on the tool", _INK, self._font, anchor="ma")
        fast = "" if self._speed == 1.0 else f"   {self._speed:g} x as fast"
        pen.text((18, 18), f"{time:.1f} s{fast}", _INK, self._large)


def _arrow(picture: Image.Image, column: float, row: float, load: float) -> None:
    """An arrow from the tool in the direction of the load, 3 px/N."""
    if abs(load) < 1.0:
        return
    pen = ImageDraw.Draw(picture)
    tip = row + 3.0 * load
    wing = 7.0 if load > 0 else -7.0
    pen.line((column, row, column, tip - wing), fill=_OVER, width=3)
    pen.polygon(((column, tip), (column - 6, tip - 1.6 * wing), (column + 6, tip - 1.6 * wing)), fill=_OVER)
