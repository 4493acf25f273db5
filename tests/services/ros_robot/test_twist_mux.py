"""Who of several sources drives the base, and what a lock keeps away."""

from __future__ import annotations

import pytest

from services.ros_robot.twist_mux import LOCKS, SOURCES, Entry, TwistMux

SERVOING, JOYSTICK = "/servoing_cmd_vel", "/joy_vel"


def test_the_highest_live_priority_alone_is_forwarded() -> None:
    mux = TwistMux()
    assert mux.passes(SERVOING, 0.0)
    assert mux.passes(JOYSTICK, 0.1)
    assert not mux.passes(SERVOING, 0.2)
    assert not mux.passes(SERVOING, 0.1 + SOURCES[JOYSTICK].timeout)
    assert mux.passes(SERVOING, 0.2 + SOURCES[JOYSTICK].timeout)


@pytest.mark.parametrize(("lock", "held"), [("/pause_navigation", (True, False)), ("/stop_closing_loop", (True, True))])
def test_a_lock_keeps_lower_priorities_away_until_it_is_released(lock: str, held: tuple[bool, bool]) -> None:
    mux = TwistMux()
    mux.lock(lock, True, 0.0)
    assert (not mux.passes(SERVOING, 1.0), not mux.passes(JOYSTICK, 2.0)) == held
    assert mux.held_by(SERVOING, 3.0) == lock
    mux.lock(lock, False, 3.0)
    assert mux.passes(JOYSTICK, 4.0)


def test_a_lock_without_a_timeout_is_free_until_it_speaks() -> None:
    assert all(lock.timeout == 0.0 for lock in LOCKS.values())
    assert TwistMux().held_by(SERVOING, 100.0) == ""


def test_a_lock_with_a_timeout_that_falls_silent_is_engaged() -> None:
    mux = TwistMux(locks={"/alive": Entry(255, 0.5)})
    assert mux.held_by(JOYSTICK, 0.0) == "/alive"
    mux.lock("/alive", False, 1.0)
    assert mux.passes(JOYSTICK, 1.4)
    assert not mux.passes(JOYSTICK, 1.6)
