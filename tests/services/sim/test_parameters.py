"""The simulation's parameters that depend on one another."""

from __future__ import annotations

import pytest

from services.sim.parameters import SimParameters
from shared.parameters import Refused


def test_by_default_it_is_all_of_it_and_a_place_that_is_given_holds_in_every_scene() -> None:
    assert SimParameters().scene == "full"
    for scene in ("full", "carry"):
        assert SimParameters.of({"scene": scene, "panel_position": [0.8, 0.0, 0.9]}).panel_position == (0.8, 0.0, 0.9)
    with pytest.raises(Refused, match="scene is 'sea', wanted one of 'full', 'load', 'carry'"):
        SimParameters.of({"scene": "sea"})


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"real_time_factor": 0.2}, "ft_rate is 100 Hz at a real_time_factor of 0.2: 20 Hz"),
        ({"real_time_factor": 0.1, "ft_rate": 300.0}, "joint_rate is 100 Hz"),
        ({"real_time_factor": 0.5, "ft_rate": 30.0}, "raise ft_rate to 60 Hz"),
    ],
)
def test_sensors_too_slow_in_real_time_are_refused(settings: dict[str, float], says: str) -> None:
    with pytest.raises(Refused) as refusal:
        SimParameters.of(settings)
    assert says in str(refusal.value)
