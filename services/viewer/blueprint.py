"""The layout of the view: the sentence on top, and what explains it without a click; all else is in further tabs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import rerun as rr
import rerun.blueprint as rrb

from services.viewer.draw import camera, curves, states, tool, traffic, why
from services.viewer.draw.robot import BASE, shapes
from services.viewer.sentence import AXES, UNITS

SHOWN = 20.0
"""Time [s] that curves reach back."""
_SOLID = [
    rr.Boxes3D.from_fields(fill_mode="solid"),
    rr.Cylinders3D.from_fields(fill_mode="solid"),
    rr.Ellipsoids3D.from_fields(fill_mode="solid"),
]
"""The robot's shapes would come as wire frames."""
_LAST = rrb.VisibleTimeRange(
    "time",
    start=rrb.TimeRangeBoundary.cursor_relative(seconds=-SHOWN),
    end=rrb.TimeRangeBoundary.cursor_relative(seconds=0.0),
)


class Eye(NamedTuple):
    """Where the scene is looked at from: position and what is in the middle [m], in the axes of base."""

    position: tuple[float, float, float] = (1.7, -2.0, 1.35)
    middle: tuple[float, float, float] = (0.7, -0.15, 0.5)


_FRONT = Eye()
"""From the right, in front: robot, panel and person are in sight."""
_PLAYED = rrb.TimePanel(state="collapsed", timeline="time", play_state="playing")
"""Of a recording: from its beginning."""


def layout(tab: int = 0, eye: Eye = _FRONT, live: bool = True) -> rrb.Blueprint:
    """All views and where they stand, with a tab in front; a recording is played from its beginning."""
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.TextDocumentView(origin=why.NOW, name="why"),
            rrb.Tabs(
                rrb.Horizontal(_scene(eye), _explanation(), column_shares=[5, 4], name="robot"),
                _axes(),
                _numbers(),
                rrb.TextLogView(origin=why.HISTORY, name="what was said"),
                active_tab=tab,
            ),
            row_shares=[5, 27],
        ),
        rrb.TimePanel(state="collapsed", timeline="time", play_state="following") if live else _PLAYED,
        collapse_panels=True,
        auto_views=False,
    )


SIDES = "", "beside"
"""Paths below which two recordings are drawn beside each other."""


def side_by_side(names: Sequence[str]) -> rrb.Blueprint:
    """Two recordings on one time axis: of each, under its name, the sentence, the scene, limits, force and speed."""
    return rrb.Blueprint(
        rrb.Horizontal(*(_column(name, side) for name, side in zip(names, SIDES, strict=True))),
        _PLAYED,
        collapse_panels=True,
        auto_views=False,
    )


def _column(name: str, side: str) -> rrb.Vertical:
    return rrb.Vertical(
        rrb.TextDocumentView(origin=f"{_root(side)}/{why.NOW}", name=name),
        _scene(_ASIDE, side=side),
        _used(side),
        _plot("force [N]; thin: its limits", _of_axes(curves.KEYS[:3], curves.WRENCH, curves.LIMIT), side=side),
        _plot(f"speed of the tool [m/s]: {_WHOSE}", (curves.SPEED,), side=side),
        row_shares=[5, 14, 5, 5, 4],
    )


FILM_ROWS = 14, 62, 24
"""Shares of the height that words, scene, and what is below have in a film."""
_ASIDE = Eye((0.75, -2.5, 1.35), (1.15, -0.2, 0.78))
"""From the side: robot, panel and person are in sight, wherever the base goes."""


def filmed(words: str, camera_on: bool) -> rrb.Blueprint:
    """What a film shows, without any frame: words, the scene, the head camera's picture if there is one, the limits.

    Args:
        words: entity of the text.
        camera_on: whether the camera has told anything.
    """
    seen = [rrb.Spatial2DView(origin=camera.PICTURE, name="head camera", titlebar=False)] if camera_on else []
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.TextDocumentView(origin=words, name="words", titlebar=False),
            # Names of limits would stand before the robot, and the words name them.
            _scene(_ASIDE, titlebar=False, hidden=[f"- /{tool.ACTIVE}/names", f"- /{camera.MARKER}/name"]),
            rrb.Horizontal(*seen, _used(), column_shares=[1] * len(seen) + [3]),
            row_shares=FILM_ROWS,
        ),
        rrb.TopPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="hidden", timeline="time"),
        auto_views=False,
    )


def _scene(eye: Eye, titlebar: bool = True, hidden: Sequence[str] = (), side: str = "") -> rrb.Spatial3DView:
    at = _root(side)
    return rrb.Spatial3DView(
        origin="/",
        contents=[
            f"{at}/world/**",
            f"/{shapes(side)}/**",
            f"- /{shapes(side)}/tiago_dual/collision_geometries/**",
            f"- {at}/{camera.PICTURE}",
            *hidden,
        ],
        name="robot, forces and limits",
        titlebar=titlebar,
        defaults=_SOLID,
        eye_controls=rrb.EyeControls3D(
            position=eye.position, look_target=eye.middle, eye_up=(0, 0, 1), tracking_entity=f"{at}/{BASE}"
        ),
        line_grid=rrb.LineGrid3D(spacing=0.5),
    )


def _explanation() -> rrb.Vertical:
    return rrb.Vertical(
        rrb.Horizontal(
            rrb.Spatial2DView(
                origin=camera.PICTURE, contents=["$origin/**", f"/{camera.MARKER}/**"], name="head camera"
            ),
            _timeline(states.PHASES, "phases"),
            column_shares=[2, 3],
        ),
        _used(),
        _plot("force [N]; thin: its limits", _of_axes(curves.KEYS[:3], curves.WRENCH, curves.LIMIT)),
        _plot("torque [Nm]; thin: its limits", _of_axes(curves.KEYS[3:], curves.WRENCH, curves.LIMIT)),
        row_shares=[6, 4, 3, 3],
    )


def _used(side: str = "") -> rrb.TimeSeriesView:
    return _plot(
        "used of each limit [%]: x red, y green, z blue; torques pale",
        (curves.USED,),
        rrb.ScalarAxis(range=(0.0, 120.0), zoom_lock=True),
        side=side,
    )


def _axes() -> rrb.Vertical:
    """Each axis of the wrench by itself, in its error band and between its limits."""
    each = [
        _plot(f"{name} [{unit}]; pale: its error band; thin: its limits", _of_axes([key], *_PARTS))
        for name, unit, key in zip(AXES, UNITS, curves.KEYS, strict=True)
    ]
    pairs = [rrb.Horizontal(force, torque) for force, torque in zip(each[:3], each[3:], strict=True)]
    return rrb.Vertical(*pairs, name="axes")


def _numbers() -> rrb.Horizontal:
    """Margins, speeds, the certificate, and how everybody is."""
    return rrb.Horizontal(
        rrb.Vertical(
            _plot("left of the force limits [N]", (f"{curves.MARGIN}/force",)),
            _plot("left of the torque limits [Nm]", (f"{curves.MARGIN}/torque",)),
            _plot("gamma purple, V green-blue", (curves.CERTIFICATE,)),
            _plot("solution of the control law [us]", (curves.SOLVE,)),
        ),
        rrb.Vertical(
            _plot(f"speed of the tool [m/s]: {_WHOSE}", (curves.SPEED,)),
            _plot(f"turning of the tool [rad/s]: {_WHOSE}", (curves.TURN,)),
            _plot("base [m/s, rad/s]: x red, y green, turning blue; commanded pale", (curves.BASE,)),
            _plot("step of each service, 99 of 100 within [ms]", (curves.LOOP,), legend=True),
        ),
        rrb.Vertical(
            _timeline(states.HEALTH, "health"),
            _plot("rate of each topic [% of nominal]", (traffic.RATE,), rrb.ScalarAxis(range=(0.0, 150.0))),
            _plot("later than at its fastest [ms]", (traffic.DELAY,)),
            row_shares=[5, 3, 3],
        ),
        name="numbers",
    )


_WHOSE = "measured blue, commanded amber, largest red"
_PARTS = curves.WRENCH, curves.LIMIT


def _root(side: str) -> str:
    return f"/{side}" if side else ""


def _of_axes(keys: Sequence[str], *parts: str) -> tuple[str, ...]:
    return tuple(f"{part}/{key}" for part in parts for key in keys)


def _timeline(origin: str, name: str) -> rrb.StateTimelineView:
    return rrb.StateTimelineView(origin=origin, name=name, time_ranges=[_LAST])


def _plot(
    name: str, entities: tuple[str, ...], axis: rrb.ScalarAxis | None = None, legend: bool = False, side: str = ""
) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin="/",
        contents=[f"{_root(side)}/{path}/**" for path in entities],
        name=name,
        axis_y=axis,
        plot_legend=rrb.PlotLegend(visible=legend),
        time_ranges=[_LAST],
    )
