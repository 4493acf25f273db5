"""The one service loop: newest inputs -> step or brake -> publish -> account for time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from shared import faults
from shared.clock import Clock, nanoseconds, seconds
from shared.faults import Fault
from shared.loop.arming import REARM_AFTER, Arming
from shared.loop.causes import explained
from shared.loop.diary import Diary, setup
from shared.loop.health import health
from shared.loop.queries import QueryDesk
from shared.loop.timing import LoopTiming
from shared.service import LONGEST_DT, Inputs, Output, Reading, Service
from shared.topics import HEALTH_RATE, SETUP_RATE, Topic, health_topic, setup_topic
from shared.wire.bus import Bus, Leave, Work
from shared.wire.publisher import Publisher
from shared.wire.subscription import Received, Subscription

BRAKE_PERIOD = 0.05
"""Time [s] between two braking outputs while an input is silent."""
STALL_PERIODS = 5
"""A step that is late by more than this many periods brakes instead."""
_NEVER = 2**62
_REARM_AFTER_NS = nanoseconds(REARM_AFTER)
_BRAKE_PERIOD_NS = nanoseconds(BRAKE_PERIOD)
_HEALTH_PERIOD_NS = nanoseconds(1.0 / HEALTH_RATE)
_SETUP_PERIOD_NS = nanoseconds(1.0 / SETUP_RATE)


class Runner:
    """Runs one service on a bus and a clock; ``poll`` does whatever is due.

    Args:
        service: what to run.
        bus: where it is connected.
        clock: the steady or the simulated clock.
        wake: called from any thread when ``poll`` has something to do.
        work: called when the driving topic has something to do, in a thread that may call ``poll`` itself, with the
            argument for it; ``wake`` if not given.
        report: told each change of the service's state, one line.
        publisher: what it publishes with; one of its own if not given.
        remark: what else is to be known of the process; asked whenever health is told.
        say: told the state and its reason as often as health.
    """

    def __init__(
        self,
        service: Service,
        bus: Bus,
        clock: Clock,
        wake: Callable[[], None] = lambda: None,
        work: Work | None = None,
        report: Callable[[str], None] = lambda line: None,
        publisher: Publisher | None = None,
        remark: Callable[[], str] = lambda: "",
        say: Callable[[str, str], None] = lambda state, detail: None,
    ) -> None:
        self.service = service
        self._bus = bus
        self._clock = clock
        self._report = report
        self._remark, self._remarked, self._cut_off = remark, "", ""
        self._say = say
        self._publisher = publisher or Publisher(bus, clock)
        self.publish = self._publisher.publish
        self._turns = {topic.key: self._publisher.share(topic) for topic in service.wiring.shares}
        wiring = service.wiring
        self._driver = wiring.driver if isinstance(wiring.driver, Topic) else None
        self._period_ns = 0 if isinstance(wiring.driver, Topic) else nanoseconds(wiring.driver)
        self.subscriptions: dict[str, Subscription] = {}
        now = clock.now_ns()
        self._diary = Diary(now)
        self._last_call = now
        self._next_tick = now + self._period_ns
        self._next_brake = _NEVER if self._driver is None else now
        self._seen: dict[str, int] = {}
        self._sessions: dict[str, int] = {}
        self._stepped = 0
        self._arming = Arming(now, wiring.startup, needed=bool(wiring.required))
        self._reported = ""
        self.fault: Fault | None = None
        self.timing = LoopTiming(clock)
        self._health_topic = health_topic(wiring.name)
        self._setup_topic = setup_topic(wiring.name)
        self._health_due = self._setup_due = 0
        self._links = bus.links()
        self._desk = QueryDesk(self.service, wake)
        for topic in dict.fromkeys((*wiring.required, *wiring.optional)):
            subscription = self.subscriptions[topic.key] = self._subscription(topic)
            driven = (work or (lambda _: wake())) if topic == self._driver else None
            bus.subscribe(topic.key, subscription.offer, driven)
        self._leave: dict[str, Leave] = {}
        self._required = [self.subscriptions[topic.key] for topic in wiring.required]
        for query in (*wiring.queries, *((wiring.parameters,) if wiring.parameters else ())):
            bus.serve(query.key, self._desk.inbox(query))
        bus.alive(wiring.name, self._publisher.session)

    def _subscription(self, topic: Topic) -> Subscription:
        named, noted = (lambda session: self._bus.present().get(session, "")), self._diary.input(topic.key)
        return Subscription(topic, self._clock, named=named, noted=noted)

    def next_deadline(self) -> int:
        """When ``poll`` is due at the latest [ns], if nothing wakes it before."""
        work = self._next_tick if self._driver is None else self._next_brake
        return min(work, self._health_due)

    def poll(self, behind: bool = False) -> None:
        """Do what is due: a step or a brake first, then queries, subscriptions and health.

        Args:
            behind: the driver's newest message arrived while the last poll was still at work.
        """
        now = self._clock.now_ns()
        self._diary.turn(now, behind)
        if now - self.next_deadline() > _REARM_AFTER_NS:
            # The whole process was stopped or starved: nobody watched the inputs meanwhile.
            self._arming.restart()
        if self._driver is None:
            if now >= self._next_tick:
                self._tick(now)
        else:
            latest = self.subscriptions[self._driver.key].latest
            if latest is not None and latest.number != self._stepped:
                self._on_sample(now, latest, behind)
            elif now >= self._next_brake:
                self._watch(now)
        if (served := self._desk.serve()) is not None:
            self._tell_setup(now, *served)
        if self.service.renewed:
            self._publisher.renew(self.service.renewed)
            self.service.renewed = ()
        self._follow_demand()
        if now >= self._health_due:
            self._tell_health(self._clock.now_ns())
        if now >= self._setup_due:
            self._tell_setup(now)

    def _follow_demand(self) -> None:
        """Subscribe to the occasional inputs that are of use, leave those that are not."""
        for topic, of_use in self.service.wiring.occasional.items():
            key = topic.key
            if of_use() == (key in self._leave):
                continue
            if key not in self._leave:
                subscription = self.subscriptions[key] = self._subscription(topic)
                self._leave[key] = self._bus.listen(key, subscription.offer)
            else:
                self._leave.pop(key)()
                # With the subscription goes all that it knows: nothing is missed meanwhile, and nothing old is used
                # afterwards, not even what is still on its way.
                del self.subscriptions[key]
                self._seen.pop(key, None)

    def _tick(self, now: int) -> None:
        self._call(now, self._input_fault(now) or self._stall(now - self._next_tick, self._period_ns))
        done = self._clock.now_ns()
        self._next_tick += self._period_ns
        self.timing.add(done - now, late=done > self._next_tick)
        if self._next_tick < done:
            self._next_tick = done + self._period_ns

    def _on_sample(self, now: int, latest: Received, behind: bool) -> None:
        assert self._driver is not None
        subscription = self.subscriptions[self._driver.key]
        period_ns = nanoseconds(subscription.period)
        # From the first message that found the loop busy: several that the network delivers at once are no overrun.
        since = self._last_call if behind else subscription.waiting_since(self._stepped)
        self._stepped = latest.number
        self._call(now, self._input_fault(now) or self._stall(now - since, period_ns))
        done = self._clock.now_ns()
        self.timing.add(done - latest.arrival_ns, late=0 < period_ns < done - since)

    def _watch(self, now: int) -> None:
        """Brake if an input has gone missing; healthy ones wait for the driver's next message."""
        fault = self._input_fault(now)
        if fault is not None:
            self._call(now, fault)
        else:
            self._next_brake = self._brake_deadline(now)

    def _stall(self, late_ns: int, period_ns: int) -> Fault | None:
        limit_ns = STALL_PERIODS * period_ns
        if self.service.wiring.overrun_share >= 1.0 or not 0 < limit_ns < late_ns:
            return None
        return faults.stalled(seconds(late_ns), seconds(limit_ns))

    def _input_fault(self, now: int) -> Fault | None:
        """The most fundamental fault of the inputs or the loop, after keeping account of the start-up."""
        wiring = self.service.wiring
        worst: Fault | None = None
        for subscription in self._required:
            fault = subscription.fault(now, self.service.max_delay)
            if fault is not None and (worst is None or fault.severity < worst.severity):
                worst = explained(fault, subscription.topic, self._bus)
            if (latest := subscription.latest) is not None:
                key, session = subscription.topic.key, latest.header.session
                if self._sessions.setdefault(key, session) != session:
                    self._sessions[key] = session
                    self._arming.restart()
        if worst is None:
            worst = self.timing.fault(now, wiring.overrun_share)
        return self._arming.judge(now, worst)

    def _call(self, now: int, fault: Fault | None) -> None:
        dt = min(seconds(now - self._last_call), LONGEST_DT)
        self._last_call = now
        if fault is None:
            try:
                self._send(now, self.service.step(self._inputs(now), dt), True)
            except (ArithmeticError, ValueError, LookupError) as problem:
                fault = faults.internal(problem)
                self._send(now, self.service.brake(fault, 0.0), False)
        else:
            self._send(now, self.service.brake(fault, dt), False)
        self.fault = fault
        self._next_brake = self._brake_deadline(now)
        self._diary.done(self._clock.now_ns())
        self._tell(fault)

    def _send(self, now: int, outputs: Iterable[Output], healthy: bool) -> None:
        for output in outputs:
            if output.payload is None:
                # The stamp says how old the content is, not when it got away: a process that is stopped in the middle
                # of a step must not send what it computed before as if it were fresh.
                stamp = now - nanoseconds(output.late) if output.late else now
                self.publish(output.topic, output.message, output.valid and healthy, stamp)
            else:
                self._bus.publish(output.topic.key, output.payload)

    def _brake_deadline(self, now: int) -> int:
        if self._driver is None:
            return _NEVER
        if self.fault is not None:
            return now + _BRAKE_PERIOD_NS
        deadline = _NEVER
        for subscription in self._required:
            if subscription.latest and (limit := subscription.age_limit) < math.inf:
                deadline = min(deadline, subscription.latest.arrival_ns + nanoseconds(limit) + 1)
        return deadline

    def _inputs(self, now: int) -> Inputs:
        readings = {}
        refusals, refused = {}, {}
        for key, subscription in self.subscriptions.items():
            if text := subscription.refusals:
                refusals[key] = text
                if (fault := subscription.refused(now)) is not None:
                    refused[key] = fault.text
            latest = subscription.latest
            if latest is None:
                continue
            new = self._seen.get(key) != latest.number
            self._seen[key] = latest.number
            age = seconds(now - latest.arrival_ns) + latest.delay
            readings[key] = Reading(latest.message, latest.header, age, new)
        on_demand = self.service.wiring.on_demand
        wanted = frozenset(topic.key for topic in on_demand if self._bus.wanted(topic.key))
        return Inputs(readings, refusals, wanted, refused, self._taken(), self._bus.cut_off(), self._links)

    def _taken(self) -> dict[str, str]:
        """By key, who else publishes what the service publishes at present, and was first."""
        return {key: who for key, turn in self._turns.items() if (who := turn.taken()) and turn.speaking}

    def _tell(self, fault: Fault | None) -> None:
        kind = "" if fault is None else f"{fault.kind.value} {fault.key}"
        if kind != self._reported:
            self._reported = kind
            self._report(f"{self.service.wiring.name}: {'working' if fault is None else fault.text}")

    def _tell_health(self, now: int) -> None:
        self._health_due = now + _HEALTH_PERIOD_NS
        self._links = self._bus.links()
        remark = self._remark()
        if remark != self._remarked:
            self._remarked = remark
            if remark:
                self._report(f"{self.service.wiring.name}: {remark}")
        before, self._cut_off = self._cut_off, self._bus.cut_off()
        if bool(before) != bool(self._cut_off):
            # A robot whose router hangs can say it nowhere else.
            word = f"nobody could stop the robot: {self._cut_off}" if self._cut_off else "it can be stopped again"
            self._report(f"{self.service.wiring.name}: {word}")
        told = self.fault, self.timing, self.subscriptions, self._taken(), self._links, remark
        message = health(now, self.service, *told)
        self.publish(self._health_topic, message, valid=self.fault is None)
        self._say(message.state, message.detail)

    def _tell_setup(self, now: int, key: str = "", request: bytes = b"") -> None:
        """Stamped with the moment of the poll, in which the request under that key was taken up."""
        self._setup_due = now + _SETUP_PERIOD_NS
        self.publish(self._setup_topic, setup(self.service, self._diary, key, request), stamp=now)

    def close(self) -> None:
        """Brake once more, so that the robot need not wait for silence."""
        self._call(self._clock.now_ns(), faults.SHUTDOWN)
