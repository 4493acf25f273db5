"""Whatever comes in spoilt, late, twice or not at all is never used, and named; what is sound again is used again."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from shared.messages import Stop
from shared.topics import ANYBODY, STOP, WRENCH_EXTERNAL, Topic
from tests.promises.subjects import SERVICES, Subject
from tests.promises.surroundings import PATIENCE, Surroundings
from tests.promises.worlds import STRANGE
from tests.support.stand_in import Spoil, changed, late, silently
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

ON_TIME = 0.02
"""Time [s] between two turns of the test's own thread beyond which a measurement says nothing about the service."""
WITHIN = 0.08
"""Time [s] beyond the largest age of an input, and a period of the output, within which its loss is told."""
KINDS: dict[str, Callable[[], Spoil]] = {
    "silent": lambda: silently,
    "repeated": lambda: changed(seq=3),
    "late": lambda: late(0.4),
    "invalid": lambda: changed(valid=False),
}


def every(needs: Callable[[Subject], object]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("subject", [*filter(needs, SERVICES)], ids=repr)


REQUIRED = pytest.mark.parametrize(
    ("subject", "topic"),
    [(subject, topic) for subject in SERVICES for topic in subject.required],
    ids=lambda value: getattr(value, "key", None) or repr(value),
)


@REQUIRED
def test_a_required_input_in_every_way_spoilt_brakes_and_recovers(around: Surroundings, topic: Topic) -> None:
    around.break_off(topic, silently)
    around.counts_every_spoilt(topic)
    assert not around.works()
    around.names(topic.key, "messages rejected")
    around.spoil.clear()
    around.goes_on("spoilt payloads")


@every(lambda subject: subject.optional)
def test_an_optional_input_in_every_way_spoilt_changes_nothing(around: Surroundings) -> None:
    around.counts_every_spoilt(*around.subject.optional)
    if around.subject.process.lives_as:
        # A megabyte every few milliseconds holds up what a bridge hears of its robot, too: it latches a stop for that.
        around.begun()
    around.goes_on("spoilt payloads")


@REQUIRED
@pytest.mark.parametrize("kind", KINDS)
def test_a_required_input_that_fails_brakes_in_time_and_recovers(around: Surroundings, topic: Topic, kind: str) -> None:
    output = around.subject.output
    assert output is not None
    refused, said = around.refused(topic.key), around.heard[output.key]
    for _ in range(10):
        around.lateness = 0.0
        around.break_off(topic, KINDS[kind]())
        onset, punctual = around.bus.last_sent_ns[topic.key], around.lateness < ON_TIME
        around.names(topic.key)
        throughout(lambda: not around.works(), 0.3, "it stays so")
        around.spoil.clear()
        around.goes_on(kind)
        if punctual:
            break
    assert punctual, "the machine never ran the test itself on time"
    first = next(one for one in said if one.arrival_ns > onset and not one.header.valid)
    assert (first.arrival_ns - onset) * 1e-9 <= topic.max_age + 1 / output.rate + WITHIN
    if kind == "repeated":
        eventually(lambda: around.refused(topic.key) > refused, PATIENCE, "what was repeated is counted")


@every(lambda subject: subject.optional)
def test_an_optional_input_that_falls_silent_is_reported_until_it_is_back(around: Surroundings) -> None:
    ageing = [topic for topic in around.subject.optional if topic.max_age < math.inf]
    around.spoil.update({topic.key: silently for topic in ageing})
    for topic in ageing:
        eventually(lambda key=topic.key: not around.report.inputs[key].ok, PATIENCE, f"{topic.key}: not ok")
    around.spoil.clear()
    for topic in ageing:
        eventually(lambda key=topic.key: around.report.inputs[key].ok, PATIENCE, f"{topic.key}: ok")
    around.goes_on("silence")


@every(lambda subject: subject.inputs)
def test_a_second_session_of_any_input_is_refused_and_counted(around: Surroundings) -> None:
    strange = {topic: STRANGE[topic] for topic in around.subject.inputs if ANYBODY not in topic.publishers}
    before = around.next_report().inputs

    for topic, fields in strange.items():
        eventually(lambda key=topic.key: key in around.sent, message=f"{topic.key} sent")
        around.spoil[topic.key] = around.second_session(topic, **fields)
    for topic in strange:
        counted = before[topic.key].rejected + 5
        eventually(lambda key=topic.key, n=counted: around.refused(key) >= n, PATIENCE, topic.key)
    around.goes_on("a second session")
    for topic in strange:
        assert around.report.inputs[topic.key].hz <= 1.3 * max(before[topic.key].hz, 10.0)


@every(lambda subject: STOP in subject.inputs)
def test_a_stop_lasts_until_a_valid_release(around: Surroundings) -> None:
    around.client.publish(STOP, Stop(True, "hand in the way"))
    output = around.subject.output
    eventually(lambda: around.subject.rests(around.said(output)), PATIENCE, lambda: f"at rest: {around.words}")
    around.names("hand in the way")
    around.client.publish(STOP, Stop(False, "nobody"), valid=False)
    throughout(lambda: not around.works(), 0.5, "it stays stopped")
    around.client.publish(STOP, Stop(False))
    around.begun()


@every(lambda subject: subject.latches)
def test_a_failed_sensor_is_latched_until_somebody_releases_it(around: Surroundings) -> None:
    around.break_off(WRENCH_EXTERNAL, changed(valid=False, fault="silent"))
    throughout(lambda: not around.works(), 0.5, "for longer than it takes to latch")
    around.spoil.clear()
    around.names("silent", "tandem resume")
    throughout(lambda: not around.works(), 1.0, "it stays at rest")
    around.client.publish(STOP, Stop(False, "resume"))
    around.goes_on("a release")
