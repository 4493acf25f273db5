"""A loop that comes too late: counted, told, braked, and never caught up. The clock moves while a step computes."""

from __future__ import annotations

from shared.faults import FaultKind
from shared.loop.timing import LoopTiming
from shared.messages import Header, TwistCommand
from shared.service import LONGEST_DT
from shared.topics import COMMAND_EE_TWIST, WRENCH_EXTERNAL
from shared.wire.codec import decode
from tests.shared.loop.rig import BusyLoop
from tests.shared.rig import ManualClock


def test_a_step_within_its_period_is_no_overrun() -> None:
    loop = BusyLoop()
    loop.run(300, period=0.001, cost=0.009)
    assert loop.runner.timing.overruns == 0


def test_late_steps_are_counted_and_more_than_a_twentieth_of_them_brakes(loop: BusyLoop) -> None:
    for _ in range(4):
        loop.run(1, cost=0.012)
        loop.run(15)
    assert loop.runner.timing.overruns == 4
    assert "brake overrun" not in loop.service.calls
    loop.run(4, cost=0.012)
    loop.run(1)
    fault = loop.runner.fault
    assert fault is not None and fault.kind is FaultKind.OVERRUN
    assert "steps were late, allowed are 5%" in fault.text
    loop.run(200)
    assert loop.runner.fault is None


def test_one_stall_of_more_than_five_periods_brakes_and_is_not_caught_up(loop: BusyLoop) -> None:
    loop.clock.advance(0.01)
    for _ in range(8):
        loop.deliver()
        loop.clock.advance(0.01)
    loop.runner.poll()
    assert loop.service.calls == ["brake overrun"]
    loop.runner.poll()
    loop.runner.poll()
    assert loop.service.calls == ["brake overrun"]
    loop.run(3)
    assert loop.service.calls == ["brake overrun"] + ["step"] * 3


def test_a_burst_that_the_network_delivers_at_once_is_no_overrun(loop: BusyLoop) -> None:
    for _ in range(50):
        loop.clock.advance(0.02)
        loop.deliver(age=0.01)
        loop.deliver()
        loop.runner.poll()
    assert loop.service.calls == ["step"] * 50
    assert loop.runner.timing.overruns == 0


def test_a_sample_that_waited_for_the_work_before_counts_that_work_as_its_own_delay(loop: BusyLoop) -> None:
    loop.run(1, cost=0.062)
    for age in (0.05, 0.04, 0.03, 0.02, 0.01, 0.0):
        loop.deliver(age)
    loop.runner.poll(behind=True)
    assert loop.service.calls == ["step", "brake overrun"]


def test_a_sample_accepted_while_the_loop_reads_is_no_overrun(loop: BusyLoop) -> None:
    subscription = loop.runner.subscriptions[WRENCH_EXTERNAL.key]
    waiting_since = subscription.waiting_since

    def racing(number: int) -> int:
        since = waiting_since(number)
        subscription.waiting_since = waiting_since  # type: ignore[method-assign]
        loop.deliver()
        return since

    subscription.waiting_since = racing  # type: ignore[method-assign]
    loop.run(1)
    loop.runner.poll()
    assert loop.service.calls == ["step"] * 2
    assert loop.runner.timing.overruns == 0


def test_dt_of_the_step_after_a_stall_is_clamped(loop: BusyLoop) -> None:
    loop.run(1, cost=5.0)
    loop.run(30)
    assert max(dt for _, dt in (*loop.service.steps, *loop.service.brakes)) <= LONGEST_DT


def test_a_timer_resynchronises_after_a_stall() -> None:
    loop = BusyLoop(driver=0.01, required=(), optional=())
    for _ in range(10):
        loop.clock.advance(0.01)
        loop.runner.poll()
    assert loop.service.calls == ["step"] * 10
    loop.clock.advance(1.0)
    for _ in range(5):
        loop.runner.poll()
    assert loop.service.calls == ["step"] * 10 + ["brake overrun"]
    assert loop.service.brakes[-1][1] == LONGEST_DT
    loop.clock.advance(0.01)
    loop.runner.poll()
    assert loop.service.calls[-1] == "step"
    assert loop.runner.next_deadline() > loop.clock.now


def test_a_service_may_declare_that_being_late_is_no_fault() -> None:
    loop = BusyLoop(driver=0.01, required=(), optional=(), overrun_share=1.0)
    for _ in range(50):
        loop.clock.advance(0.5)
        loop.runner.poll()
    assert loop.service.calls == ["step"] * 50


def test_a_loop_that_is_too_rare_is_not_judged_by_shares() -> None:
    clock = ManualClock()
    timing = LoopTiming(clock)
    for _ in range(50):
        clock.advance(0.1)
        timing.add(10**9, late=True)
        assert timing.fault(clock.now, 0.05) is None
    assert timing.overruns == 50


def test_latencies_are_those_of_the_last_second() -> None:
    clock = ManualClock()
    timing = LoopTiming(clock)
    assert timing.summary(clock.now) == (0.0, 0.0, 0.0)
    for number in range(200):
        clock.advance(0.01)
        timing.add(10**9 if number < 90 else 200_000 if number % 50 == 0 else 100_000, late=False)
    rate, p50, p99 = timing.summary(clock.now)
    assert rate in (100.0, 101.0)
    assert p50 == 100.0 and p99 == 200.0
    clock.advance(2.0)
    assert timing.summary(clock.now) == (0.0, 0.0, 0.0)


def test_after_an_absence_of_the_whole_process_it_arms_anew(loop: BusyLoop) -> None:
    """Stopped and continued: the inputs are healthy again at the first look, but nobody watched them meanwhile."""
    loop.clock.advance(2.0)
    loop.run(45)
    assert "step" not in loop.service.calls
    loop.run(10)
    assert loop.service.calls[-1] == "step"


def test_a_process_stopped_within_a_step_does_not_pass_its_output_off_as_fresh(loop: BusyLoop) -> None:
    headers: list[Header] = []
    loop.bus.subscribe(COMMAND_EE_TWIST.key, lambda payload: headers.append(decode(TwistCommand, payload)[0]))
    before = loop.clock.now
    loop.run(1, cost=1.0)
    loop.scheduler.run_until(0)
    assert loop.clock.now - before > 10**9
    assert headers[0].stamp - before == 10_000_000
