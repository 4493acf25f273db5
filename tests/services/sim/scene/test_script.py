"""A script is either understood in full, or refused in one line that says where and why."""

from __future__ import annotations

import pytest

from services.sim.scene.script import BUILT_IN, read
from shared.parameters import Refused


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_scripts_are_understood(name: str) -> None:
    assert [phase.do for phase in read(name)][:3] == ["wait", "take_hold", "lift"]


def test_the_whole_scenario_is_in_the_one_called_carry() -> None:
    phases = read("carry")
    assert {phase.do for phase in phases} == {"wait", "take_hold", "lift", "move", "turn", "lower", "let_go"}
    assert 90.0 in [phase.angle for phase in phases]
    assert all(phase.pause == 1.0 for phase in phases)


def test_values_and_defaults() -> None:
    (phase,) = read('[[phase]]\ndo = "turn"\nabout = "z"\nangle = -45\nspeed = 0.3\npause = 0')
    assert (phase.about, phase.angle, phase.speed, phase.pause) == ("z", -45.0, 0.3, 0.0)
    (phase,) = read('[[phase]]\ndo = "move"\nby = [1, 0, -0.1]')
    assert (phase.by.tolist(), phase.speed, phase.patience) == ([1.0, 0.0, -0.1], 0.1, 20.0)


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("dance", "neither 'carry' nor TOML"),
        ("", "wanted 1 to 100 tables [[phase]]"),
        ("phase = 3", "wanted 1 to 100 tables"),
        ("phase = [3]", "phase 1 is 3, wanted a table"),
        ('colour = "red"\n[[phase]]\ndo = "let_go"', "['colour', 'phase']"),
        ('[[phase]]\ndo = "dance"', "phase 1: do is 'dance', wanted one of wait, take_hold, lift"),
        ("[[phase]]\nspeed = 1", "phase 1: do is missing"),
        ('[[phase]]\ndo = "wait"\nuntil = "grasp"\n"a\\nb" = 1', "is nothing that wait has"),
        ("[[phase]]\ndo = [1]", "phase 1: do is [1], wanted text"),
        (
            '[[phase]]\ndo = "let_go"\n[[phase]]\ndo = "lift"\nheight = "high"',
            "phase 2: height is 'high', wanted a number",
        ),
        ('[[phase]]\ndo = "lift"\nheight = 9', "height is 9, wanted 0 to 1 m"),
        ('[[phase]]\ndo = "lift"\nheight = nan', "height is nan"),
        ('[[phase]]\ndo = "lift"\nheight = true', "height is True"),
        ('[[phase]]\ndo = "lift"', "height is missing; lift needs it"),
        ('[[phase]]\ndo = "lift"\nheight = 0.1\nby = [1, 2, 3]', "'by' is nothing that lift has; it has height"),
        ('[[phase]]\ndo = "move"\nby = [1, 2]', "by has 2 elements, wanted 3"),
        ('[[phase]]\ndo = "move"\nby = [1, 2, 99]', "by is [1.0, 2.0, 99.0], wanted every element -5 to 5 m"),
        ('[[phase]]\ndo = "turn"\nabout = "w"\nangle = 1', "about is 'w', wanted one of x, z"),
        ('[[phase]]\ndo = "wait"\nuntil = "tea"', "until is 'tea', wanted one of grasp, release"),
        ('[[phase]]\ndo = "lower"\nspeed = 0', "speed is 0, wanted 0.01 to 1"),
        ("x" * 70000, "70000 characters"),
        ('[[phase]]\ndo = "let_go"\n' * 101, "wanted 1 to 100 tables"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(script: str, says: str) -> None:
    with pytest.raises(Refused) as refusal:
        read(script)
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)
