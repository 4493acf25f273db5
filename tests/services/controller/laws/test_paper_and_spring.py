"""The paper's law and the spring against their formulas, and what the paper's law does at 30 Hz."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.controller.laws.paper_and_spring import PaperLaw, StiffnessLaw
from shared.spatial import pose_error
from tests.services.controller import closed_form
from tests.services.controller.contacts import LIMIT, agile, state

sixes = st.tuples(*(st.floats(-1, 1, allow_subnormal=False),) * 6)


def barrier(wrench: np.ndarray, alpha: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Theorem 1 solved for v_i."""
    lower, upper = np.full(6, -np.inf), np.full(6, np.inf)
    for i in range(6):
        if wrench[i] != 0.0:
            bound = 0.5 * alpha[i] * (wrench[i] ** 2 - LIMIT[i] ** 2) / wrench[i]
            if wrench[i] > 0:
                lower[i] = bound
            else:
                upper[i] = bound
    return lower, upper


@settings(max_examples=150, deadline=None)
@given(share=sixes, position=st.tuples(*(st.floats(-1, 1),) * 3), turn=st.tuples(*(st.floats(-1, 1),) * 3))
def test_paper_law_is_the_paper_s_problem(share: tuple, position: tuple, turn: tuple) -> None:
    parameters = agile(law="paper", barrier_rate=(1.0, 1.0, 1.0, 0.1, 0.1, 0.1))
    wrench = LIMIT * np.array(share) * 1.3
    given_state = state(wrench=wrench, position=position, turn=turn)
    output = PaperLaw(parameters).step(given_state, 0.01)
    assert output.failure is None
    error = pose_error(given_state.position, given_state.rotation, np.zeros(3), np.eye(3))
    lower, upper = barrier(wrench, np.array(parameters.barrier_rate))
    speed = np.array([1.0] * 3 + [3.0] * 3)
    lower, upper = np.clip(lower, -speed, speed), np.clip(upper, -speed, speed)
    v = closed_form.twist(error, lower, upper, 10.0, 1.0)
    assert output.twist == pytest.approx(closed_form.shortened(v, 1.0, 3.0), abs=2e-6)
    assert output.lyapunov == pytest.approx(0.5 * error @ error)
    assert output.relaxation >= error @ output.twist + 10.0 * output.lyapunov - 1e-9


def test_barrier_beyond_the_speed_limit_closes_the_box_on_it() -> None:
    output = PaperLaw(agile(law="paper")).step(state(wrench=[0, 0, 100.0, 0, 0, 0]), 0.01)
    assert output.twist == pytest.approx([0, 0, 1.0, 0, 0, 0], abs=1e-6)
    assert output.yielding and output.active[2] == 1


@pytest.mark.parametrize("side", [-1, 1])
def test_active_says_which_limit_of_the_wrench_is_near(side: int) -> None:
    output = PaperLaw(agile(law="paper")).step(state(wrench=[0, side * 11.0, 0, 0, 0, 0]), 0.01)
    assert output.active.tolist() == [0, side, 0, 0, 0, 0]
    assert side * output.twist[1] > 0, "it moves with the force"


@settings(max_examples=50, deadline=None)
@given(share=sixes, position=st.tuples(*(st.floats(-0.3, 0.3),) * 3))
def test_stiffness_law_is_a_damped_spring(share: tuple, position: tuple) -> None:
    parameters = agile(law="stiffness")
    wrench = 5.0 * np.array(share)
    output = StiffnessLaw(parameters).step(state(wrench=wrench, position=position), 0.01)
    K = np.array(parameters.spring_stiffness)
    error = np.concatenate((position, np.zeros(3)))
    v = (wrench - K * error) / (2.0 * K)
    speed = np.array([1.0] * 3 + [3.0] * 3)
    assert output.twist == pytest.approx(closed_form.shortened(np.clip(v, -speed, speed), 1.0, 3.0), abs=2e-6)


def test_speeding_up_is_limited_and_slowing_down_is_not() -> None:
    law = PaperLaw(agile(law="paper", max_acceleration=(2.0,) * 6))
    speeds = [law.step(state(target=[1.0, 0, 0]), 0.01).twist[0] for _ in range(4)]
    assert np.diff([0.0, *speeds]) == pytest.approx([0.02] * 4, rel=0.05)
    assert law.step(state(), 0.01).twist[0] == pytest.approx(0.0, abs=1e-6)
