"""Curves over time: wrench and limits, share of each limit in use, margins, speeds with bounds, gamma and V."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import rerun as rr

from services.viewer.draw.colours import AMBER, AXES, FAINT, GREY, PALE, PURPLE, RED, TEAL
from services.viewer.sample import Sample
from services.viewer.sentence import AXES as NAMES
from services.viewer.sentence import used_share
from shared.messages import (
    BaseState,
    BaseStatus,
    ControlStatus,
    EndEffector,
    ExternalWrench,
    Health,
    RobotStatus,
    TwistCommand,
)

WRENCH, LIMIT = "curves/wrench", "curves/limit"
"""Below them one entity for each axis: what is felt with its error band, and its limits."""
USED, MARGIN = "curves/used", "curves/margin"
SPEED, TURN, BASE = "curves/speed", "curves/turn", "curves/base"
CERTIFICATE, SOLVE, LOOP = "curves/certificate", "curves/solve", "curves/loop"
KEYS = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Last parts of the entities of the six axes."""
_GAP = np.full(6, np.nan)
"""Where nothing was told."""


def lines(
    rec: rr.RecordingStream, path: str, names: Sequence[str], colors: Sequence, widths: Sequence[float] = ()
) -> None:
    """Names and colours of an entity's curves, and their widths [points of the screen]."""
    style = rr.SeriesLines(names=list(names), colors=list(colors), widths=list(widths) or [1.5] * len(names))
    rec.log(path, style, static=True)


def style(rec: rr.RecordingStream) -> None:
    """Names and colours, once."""
    for axis, key in enumerate(KEYS):
        colour, faint = AXES[axis % 3], FAINT[axis % 3]
        band = ("less its error bound", "plus its error bound")
        lines(rec, f"{WRENCH}/{key}", [NAMES[axis], *band], [colour, faint, faint], [2.0, 0.8, 0.8])
        lines(rec, f"{LIMIT}/{key}", ["lower limit", "upper limit"], [colour] * 2, [0.8] * 2)
    lines(rec, USED, (*NAMES, "limit"), (*AXES, *PALE, RED))
    lines(rec, f"{MARGIN}/force", NAMES[:3], AXES)
    lines(rec, f"{MARGIN}/torque", NAMES[3:], AXES)
    for path in (SPEED, TURN):
        lines(rec, f"{path}/measured", ["measured"], [AXES[2]])
        lines(rec, f"{path}/commanded", ["commanded"], [AMBER])
        lines(rec, f"{path}/largest", ["largest"], [RED], [1.0])
    lines(rec, f"{BASE}/measured", ["forwards", "sideways", "turning"], AXES)
    lines(rec, f"{BASE}/commanded", ["forwards, commanded", "sideways, commanded", "turning, commanded"], PALE)
    lines(rec, f"{CERTIFICATE}/relaxation", ["gamma"], [PURPLE])
    lines(rec, f"{CERTIFICATE}/lyapunov", ["V"], [TEAL])
    lines(rec, SOLVE, ["one solution"], [GREY])


def curve(rec: rr.RecordingStream, path: str, times: rr.TimeColumn, values: np.ndarray) -> None:
    """Add rows (n,) or (n, k) to an entity's curves at their times; what is not finite leaves a gap."""
    width = 1 if values.ndim == 1 else values.shape[1]
    columns = rr.Scalars.columns(scalars=values.ravel()).partition([width] * len(values))
    rec.send_columns(path, indexes=[times], columns=columns)


def _times(samples: Sequence[Sample]) -> rr.TimeColumn:
    """Of all curves of these messages: to make it costs more than to send it."""
    nanoseconds = np.array([sample.time for sample in samples]) * 1e9
    return rr.TimeColumn("time", duration=nanoseconds.astype("timedelta64[ns]"))


def wrench(rec: rr.RecordingStream, samples: Sequence[Sample[ExternalWrench]]) -> None:
    """Force and torque of the six axes, each between its error bounds."""
    times = _times(samples)
    felt = np.array([(*sample.message.force, *sample.message.torque) for sample in samples])
    bound = np.array([sample.message.error_bound for sample in samples])
    banded = np.stack((felt, felt - bound, felt + bound), axis=2)
    for axis, key in enumerate(KEYS):
        curve(rec, f"{WRENCH}/{key}", times, banded[:, axis])


def control(rec: rr.RecordingStream, samples: Sequence[Sample[ControlStatus]]) -> None:
    """Limits around the nominal wrench, the share of each that is in use, what is left; gamma and V."""
    times, told = _times(samples), [sample.message for sample in samples]
    share = np.array([used_share(status) for status in told])
    curve(rec, USED, times, 100.0 * np.column_stack((share, np.ones(len(samples)))))
    margin = np.where(np.isnan(share), np.nan, np.array([status.margin for status in told]))
    curve(rec, f"{MARGIN}/force", times, margin[:, :3])
    curve(rec, f"{MARGIN}/torque", times, margin[:, 3:])
    limit = np.array([_GAP if status.limit is None or not status.limit.any() else status.limit for status in told])
    nominal = np.array([_GAP if status.nominal is None else status.nominal for status in told])
    around = np.stack((nominal - limit, nominal + limit), axis=2)
    for axis, key in enumerate(KEYS):
        curve(rec, f"{LIMIT}/{key}", times, around[:, axis])
    curve(rec, f"{CERTIFICATE}/relaxation", times, np.array([status.relaxation for status in told]))
    curve(rec, f"{CERTIFICATE}/lyapunov", times, np.array([status.lyapunov for status in told]))
    curve(rec, SOLVE, times, np.array([status.solve_us for status in told]))


def tool(rec: rr.RecordingStream, samples: Sequence[Sample[EndEffector]]) -> None:
    """How fast the tool moves and turns."""
    curve(rec, f"{SPEED}/measured", _times(samples), _norms([sample.message.linear for sample in samples]))
    curve(rec, f"{TURN}/measured", _times(samples), _norms([sample.message.angular for sample in samples]))


def command(rec: rr.RecordingStream, samples: Sequence[Sample[TwistCommand]]) -> None:
    """How fast the tool should move and turn."""
    curve(rec, f"{SPEED}/commanded", _times(samples), _norms([sample.message.linear for sample in samples]))
    curve(rec, f"{TURN}/commanded", _times(samples), _norms([sample.message.angular for sample in samples]))


def _norms(vectors: Sequence[np.ndarray]) -> np.ndarray:
    return np.linalg.norm(np.array(vectors), axis=1)


def robot(rec: rr.RecordingStream, samples: Sequence[Sample[RobotStatus]]) -> None:
    """How fast the gate lets the tool be."""
    curve(rec, f"{SPEED}/largest", _times(samples), np.array([sample.message.max_linear for sample in samples]))
    curve(rec, f"{TURN}/largest", _times(samples), np.array([sample.message.max_angular for sample in samples]))


def base_state(rec: rr.RecordingStream, samples: Sequence[Sample[BaseState]]) -> None:
    """How fast the base moves."""
    curve(rec, f"{BASE}/measured", _times(samples), np.array([sample.message.velocity for sample in samples]))


def base_status(rec: rr.RecordingStream, samples: Sequence[Sample[BaseStatus]]) -> None:
    """How fast the base should move."""
    curve(rec, f"{BASE}/commanded", _times(samples), np.array([sample.message.velocity for sample in samples]))


def loop(name: str) -> Callable[[rr.RecordingStream, Sequence[Sample[Health]]], None]:
    """Draws how long the steps of a service take."""

    def plot(rec: rr.RecordingStream, samples: Sequence[Sample[Health]]) -> None:
        took = np.array([sample.message.loop_p99_us for sample in samples])
        curve(rec, f"{LOOP}/{name}", _times(samples), took / 1e3)

    return plot
