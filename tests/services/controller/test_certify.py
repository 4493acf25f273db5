"""What `certify` prints, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from services.controller.certify import main
from services.controller.guarantee import certificates
from services.controller.parameters import ControllerParameters

LIMIT = np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0))
ERROR = np.array((0.3,) * 3 + (0.03,) * 3)
PANEL = {
    "contact_stiffness": 500.0,
    "contact_reach": (1.05, 0.3, 0.05),
    "delay": 0.0,
    "lag": 0.0,
    "max_linear": 1.0,
}


@pytest.mark.parametrize(
    ("period", "linear", "angular"),
    [
        (0.036, (0.172, 0.132, 0.081), (0.262, 0.077, 0.122)),
        (0.012, (0.515, 0.398, 0.243), (0.787, 0.232, 0.367)),
    ],
)
def test_published_speeds_of_a_person_on_a_panel(period: float, linear: tuple, angular: tuple) -> None:
    """Without delay, lag and reserve these are ``min_j W_j / (Kbar_ji T)``; a reach widened for turning lowers them."""
    parameters = ControllerParameters.of({**PANEL, "period": period, "reserve": 0.0, "max_angular": 0.3})
    found = [one.speed for one in certificates(parameters, LIMIT, ERROR)]
    published = np.minimum(np.array(linear + angular), (1.0,) * 3 + (0.3,) * 3)
    assert np.all(np.array(found) <= published * 1.01)
    assert np.all(np.array(found) >= published * 0.65)


def test_delay_and_lag_count_like_the_period() -> None:
    fast = certificates(ControllerParameters.of({**PANEL, "period": 0.06}), LIMIT, ERROR)
    slow = certificates(
        ControllerParameters.of({**PANEL, "period": 0.02, "delay": 0.02, "lag": 0.02}), LIMIT, ERROR
    )
    assert [one.speed for one in slow[:3]] == pytest.approx([one.speed for one in fast[:3]], rel=0.15)


def test_excess_grows_with_the_environment_s_speed() -> None:
    parameters = ControllerParameters.of(PANEL)
    slow, fast = (certificates(parameters, LIMIT, ERROR, speed) for speed in (0.1, 0.2))
    # Twice the speed, and twice as long to speed up to it.
    assert all(2 * one.excess < other.excess < 4 * one.excess for one, other in zip(slow, fast, strict=True))
    assert all(one.excess > 0 for one in slow)


def test_table_names_what_limits(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--torque-limit", "0.5,3,3", "--torque-error", "0.03"]) == 0
    text = capsys.readouterr().out
    assert "limit about x" in text and "mm/s" in text and "excess" in text and "strict" in text


def test_json(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    config = tmp_path / "controller.toml"
    config.write_text(
        "[controller]\nyield_start = 0.8\n[[controller.zones]]\nstiffness = 5000.0\nreach = [0.1, 0.1, 0.05]\n"
    )
    assert main(["--config", str(config), "--set", "contact_stiffness=300.0", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["form"].startswith("rounded") and len(found["axes"]) == 6
    assert all(one["speed"] > 0 for one in found["axes"])


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--force-limit", "-3"], ("--force-limit", "-3")),
        (["--force-limit", "1,2"], ("--force-limit", "1,2")),
        (["--force-limit", "x"], ("--force-limit",)),
        (["--force-error", "20"], ("25 N x", "20")),
        (["--set", "period=3.0"], ("period", "0.2")),
        (["--bogus"], ("--bogus",)),
    ],
)
def test_refusals_are_one_line_with_status_2(
    arguments: list[str], parts: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert all(part in line for part in parts), line


def test_what_the_excess_follows_from_is_printed_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    """The stiffness bound of a tool turned by 90 degrees about x is that of a reach with y and z exchanged."""
    found = []
    for reach, orientation in (
        ("[1.2, 0.05, 0.3]", "0.7071068,0,0,0.7071068"),
        ("[1.2, 0.3, 0.05]", "0,0,0,1"),
    ):
        given = [
            "--set",
            f"contact_reach={reach}",
            "--set",
            "yield_start=0.8",
            f"--orientation={orientation}",
        ]
        assert main([*given, "--torque-limit", "0.5,3,3", "--torque-error", "0.03", "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    first, second = (np.array(one["moving"]["stiffness"]) for one in found)
    assert first == pytest.approx(second, rel=1e-6)
    assert first.shape == (1, 6, 6)
    moving, speed = found[1]["moving"], found[1]["environment_speed"]
    lasts = moving["response"] + speed / (2.0 * min(moving["acceleration"][:3]))
    growth = np.linalg.norm(second[0][:, :3], axis=1) * speed * lasts
    assert moving["factor"] * growth == pytest.approx([axis["excess"] for axis in found[1]["axes"]])


@pytest.mark.parametrize("orientation", ["0,0,0,0", "0,0,1", "x"])
def test_an_orientation_that_is_none_is_refused(orientation: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([f"--orientation={orientation}", "--json"]) == 2
    assert "wanted a unit quaternion" in capsys.readouterr().err
