"""What is around the robot, as far as a simulation tells it: panel, bag and the person's hands, in world."""

from __future__ import annotations

import numpy as np
import rerun as rr

from services.viewer.draw import person
from services.viewer.draw.colours import AMBER, PURPLE
from services.viewer.draw.robot import BASE, at
from services.viewer.draw.tool import PER_NEWTON
from services.viewer.sample import Newest, Sample
from shared.sim_messages import HandState, PanelState, SimWorld
from shared.spatial import rotation_matrix
from shared.topics import STATE_EE

PANEL, HANDS, BAG = "world/panel", "world/hands", f"{BASE}/bag"
_SKIN, _WOOD, _BAG = (214, 160, 130), (214, 186, 130, 100), (120, 84, 60)
_BAG_RADIUS, _BAG_HEIGHT = 0.1, 0.3  # [m] as drawn
_NOT_TOLD = 1e-3
"""[m] A panel that is thinner than this has told no size."""


def style(rec: rr.RecordingStream) -> None:
    """What stays as it is."""
    panel = rr.Boxes3D.from_fields(colors=[_WOOD], fill_mode="solid")
    rec.log(f"{PANEL}/body", panel, static=True)
    rec.log(f"{HANDS}/hands", rr.Ellipsoids3D.from_fields(colors=[_SKIN], fill_mode="solid"), static=True)
    rec.log(f"{HANDS}/person", person.style(), static=True)
    rec.log(f"{HANDS}/force", rr.Arrows3D.from_fields(colors=[PURPLE], radii=[0.01]), static=True)
    rec.log(f"{HANDS}/wanted", rr.Points3D.from_fields(colors=[AMBER], radii=[0.025]), static=True)
    rec.log(f"{HANDS}/way", rr.LineStrips3D.from_fields(colors=[AMBER], radii=[0.003]), static=True)
    rec.log(f"{BAG}/rope", rr.LineStrips3D.from_fields(colors=[_SKIN], radii=[0.003]), static=True)
    rec.log(f"{BAG}/body", rr.Ellipsoids3D.from_fields(colors=[_BAG], fill_mode="solid"), static=True)


def world(rec: rr.RecordingStream, sample: Sample[SimWorld], newest: Newest) -> None:
    """All that is there; what is gone is taken away."""
    message = sample.message
    if message.panel is None:
        rec.log(PANEL, rr.Clear(recursive=True))
    else:
        _panel(rec, message.panel)
    if message.hand is None:
        rec.log(HANDS, rr.Clear(recursive=True))
    else:
        _hands(rec, message.hand)
        if message.panel is not None:
            _person(rec, message.hand, message.panel)
    tool = newest(STATE_EE)
    if message.bag is None or tool is None:
        rec.log(BAG, rr.Clear(recursive=True))
    else:
        _bag(rec, tool.position, message.bag.height)


def _panel(rec: rr.RecordingStream, panel: PanelState) -> None:
    rec.log(PANEL, at(panel.position, panel.orientation))
    if panel.size.min() > _NOT_TOLD:
        rec.log(f"{PANEL}/body", rr.Boxes3D.from_fields(half_sizes=[panel.size / 2.0]))


def _hands(rec: rr.RecordingStream, hand: HandState) -> None:
    rec.log(f"{HANDS}/hands", rr.Ellipsoids3D.from_fields(centers=[hand.position], half_sizes=[(0.05, 0.09, 0.035)]))
    force = rr.Arrows3D.from_fields(origins=[hand.position], vectors=[hand.force * PER_NEWTON])
    rec.log(f"{HANDS}/force", force)
    rec.log(f"{HANDS}/wanted", rr.Points3D.from_fields(positions=[hand.wanted]))
    rec.log(f"{HANDS}/way", rr.LineStrips3D.from_fields(strips=[np.array((hand.position, hand.wanted))]))


def _person(rec: rr.RecordingStream, hand: HandState, panel: PanelState) -> None:
    """Whoever the hands belong to, at the panel's end; where it is but for the hands is not told."""
    turned = rotation_matrix(panel.orientation)
    outward = turned[:, 0] * (1.0, 1.0, 0.0)
    length = float(np.linalg.norm(outward))
    if length > _NOT_TOLD:
        holds = bool(hand.force.any())
        rec.log(f"{HANDS}/person", person.person(hand.position, turned[:, 1], outward / length, holds))


def _bag(rec: rr.RecordingStream, tool: np.ndarray, height: float) -> None:
    """The bag on its rope, straight below the tool: how it swings is not told."""
    top = height + _BAG_HEIGHT
    middle = (tool[0], tool[1], height + _BAG_HEIGHT / 2.0)
    rec.log(f"{BAG}/rope", rr.LineStrips3D.from_fields(strips=[np.array((tool, (tool[0], tool[1], top)))]))
    body = rr.Ellipsoids3D.from_fields(centers=[middle], half_sizes=[(_BAG_RADIUS, _BAG_RADIUS, _BAG_HEIGHT / 2.0)])
    rec.log(f"{BAG}/body", body)
