"""TIAGo in names and numbers: what every robot process needs, simulated or real."""

from __future__ import annotations

from pathlib import Path

URDF = Path(__file__).with_name("tiago.urdf")
