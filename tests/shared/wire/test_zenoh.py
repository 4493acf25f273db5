"""The bus over a real router in a process of its own."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator

import pytest

from shared.topics import MAP_CAP
from shared.wire.bus import NoReply, Reply
from shared.wire.endpoint import BusError
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.ports import free_endpoint
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

KEY = "command/ee_twist"
"""A key whose messages come again soon, and may be dropped."""


class Pair:
    """Two participants of one router; what the second hears."""

    def __init__(self, endpoint: str) -> None:
        self.one, self.two = ZenohBus(connect=endpoint), ZenohBus(connect=endpoint)
        self.heard: list[bytes] = []
        self.two.subscribe(KEY, self.heard.append)

    def through(self) -> bool:
        """Whether payloads pass at present; sends one more each time it is asked."""
        self.one.publish(KEY, b"probe")
        return b"probe" in self.heard

    def close(self) -> None:
        self.one.close()
        self.two.close()


@pytest.fixture
def pair(shared_router: Router) -> Iterator[Pair]:
    pair = Pair(shared_router.endpoint)
    eventually(pair.through, message="the first payload through the router")
    yield pair
    pair.close()


def test_payloads_arrive_whole_and_in_order(pair: Pair) -> None:
    pair.heard.clear()
    payloads = [bytes([number]) * (1 + 7 * number) for number in range(200)]
    for payload in payloads:
        pair.one.publish(KEY, payload)
    # Any of them may be dropped, the last one too: what is sent behind them until it arrives closes the row.
    eventually(lambda: pair.one.publish(KEY, b"end") or b"end" in pair.heard, message="the end")
    arrived = [payload for payload in pair.heard if payload not in (b"probe", b"end")]
    assert arrived == [payload for payload in payloads if payload in arrived]  # never reordered
    assert arrived


@pytest.mark.parametrize("size", [0, 1_000_000, 4 * 1024 * 1024])
def test_large_payloads_pass(pair: Pair, size: int) -> None:
    eventually(lambda: pair.one.publish(KEY, bytes(size)) or bytes(size) in pair.heard)


def test_a_payload_beyond_every_size_is_lost_and_the_next_ones_pass(pair: Pair) -> None:
    pair.one.publish(KEY, bytes(20_000_000))
    pair.heard.clear()
    eventually(pair.through, message="a payload after the excessive one")
    assert max(map(len, pair.heard)) < 100


def test_two_robots_on_one_network_do_not_hear_each_other(pair: Pair, shared_router: Router) -> None:
    other = ZenohBus(robot="reem", connect=shared_router.endpoint)
    heard: list[bytes] = []
    other.subscribe(KEY, heard.append)
    other.alive("wrench", 7)
    try:
        eventually(lambda: other.publish(KEY, b"mine") or b"mine" in heard)
        pair.one.publish(KEY, b"last")
        eventually(lambda: b"last" in pair.heard)
        assert b"mine" not in pair.heard and b"probe" not in heard
        assert pair.one.living() == set() and other.living() == {"wrench"}
    finally:
        other.close()


def test_what_is_left_is_wanted_no_more_and_may_be_subscribed_to_again(pair: Pair) -> None:
    key = "sensor/camera"
    heard: list[bytes] = []
    for _ in range(2):
        leave = pair.two.listen(key, heard.append)
        eventually(lambda: pair.one.wanted(key), message="wanted")
        eventually(lambda: pair.one.publish(key, b"picture") or heard, message="a payload")
        leave()
        eventually(lambda: not pair.one.wanted(key), message="wanted no more")
        heard.clear()
        pair.one.publish(key, b"too late")
        throughout(lambda: not heard, 0.2, "nothing after leaving")
    assert pair.through()


def test_what_arrives_during_the_work_is_handed_over_first_and_worked_on_once(pair: Pair) -> None:
    sender, receiver = pair.one, pair.two
    heard: list[bytes] = []
    works: list[tuple[bool, bytes]] = []
    go_on = threading.Event()

    def work(behind: bool) -> None:
        works.append((behind, heard[-1]))
        go_on.wait(10.0)

    receiver.subscribe("stop", heard.append, work)
    eventually(lambda: sender.publish("stop", b"first") or works, message="the first work")
    passed: list[bytes] = []
    sender.subscribe("stop", passed.append)
    eventually(lambda: sender.publish("stop", b"probe") or b"probe" in passed)
    eventually(lambda: sender.publish("stop", b"newest") or b"newest" in passed)
    assert len(works) == 1
    go_on.set()
    eventually(lambda: len(works) > 1 and works[-1][1] == b"newest", message="work on the newest payload")
    assert works[1][0] and heard.index(b"probe") < heard.index(b"newest"), works


def test_queries_are_answered_at_once_or_later_from_any_thread(pair: Pair) -> None:
    pair.two.serve("wrench/tare", lambda request, reply: reply(request * 2))
    pair.two.serve("task/command", lambda request, reply: threading.Thread(target=reply, args=(b"late",)).start())
    assert eventually(lambda: _answer(pair.one, "wrench/tare", b"ab")) == b"abab"
    assert eventually(lambda: _answer(pair.one, "task/command", b"")) == b"late"


def _answer(bus: ZenohBus, key: str, request: bytes) -> bytes | None:
    try:
        return bus.query(key, request, timeout=2.0)
    except NoReply:
        return None


def test_nobody_there_and_nobody_answering_are_no_reply(pair: Pair) -> None:
    held: list[Reply] = []
    pair.two.serve("wrench/tare", lambda request, reply: held.append(reply))
    with pytest.raises(NoReply, match=r"tiago/base/parameters within 0.2 s"):
        pair.one.query("base/parameters", b"", timeout=0.2)

    def asked() -> list[Reply]:
        with pytest.raises(NoReply):
            pair.one.query("wrench/tare", b"", timeout=0.2)
        return held

    # Not the first time perhaps: the router may still have to tell the asker who serves it.
    eventually(asked, message="the request at the server")
    held[0](b"too late")  # the asker is gone: no harm
    assert pair.through()


def test_an_oversized_request_is_cut_before_it_is_looked_at(pair: Pair) -> None:
    sizes: list[int] = []
    pair.two.serve("wrench/tare", lambda request, reply: sizes.append(len(request)) or reply(b"ok"))
    eventually(lambda: _answer(pair.one, "wrench/tare", bytes(1_000_000)) == b"ok")
    assert sizes[0] == MAP_CAP + 1


def test_payloads_pass_again_soon_after_the_router_was_killed_and_restarted(
    router: Router, start: StartProcess
) -> None:
    pair = Pair(router.endpoint)
    try:
        pair.two.serve("wrench/tare", lambda request, reply: reply(b"here"))
        pair.two.alive("wrench", 7)
        eventually(pair.through)
        router.process.kill()
        eventually(lambda: not pair.one.connected(), message="the loss of the router noticed")
        pair.heard.clear()
        for _ in range(100):
            pair.one.publish(KEY, b"lost")  # neither blocks nor raises
        assert pair.one.living() == set()
        with pytest.raises(NoReply):
            pair.one.query("wrench/tare", b"", timeout=0.5)
        start("services.router", "--listen", router.endpoint).wait_for_output("listening")
        eventually(pair.through, 15.0, "payloads through the new router")
        assert b"lost" not in pair.heard
        eventually(lambda: _answer(pair.one, "wrench/tare", b"") == b"here", 15.0, "queries")
        eventually(lambda: pair.one.living() == {"wrench"}, 15.0, "liveliness")
    finally:
        pair.close()


def test_a_hung_router_holds_nobody_up_and_is_used_again_when_it_wakes(router: Router) -> None:
    pair = Pair(router.endpoint)
    try:
        eventually(pair.through)
        router.process.signal(signal.SIGSTOP)
        published = threading.Event()

        def publish() -> None:
            for _ in range(2000):
                pair.one.publish(KEY, bytes(10_000))
            published.set()

        threading.Thread(target=publish, daemon=True).start()
        eventually(published.is_set, 20.0, "20 MB published into a router that takes nothing")
        router.process.signal(signal.SIGCONT)
        pair.heard.clear()
        eventually(pair.through, 20.0, "payloads after the router woke")
    finally:
        router.process.signal(signal.SIGCONT)
        pair.close()


def test_it_waits_for_a_router_and_gives_up_when_told(start: StartProcess) -> None:
    endpoint = free_endpoint()
    asked: list[int] = []
    with pytest.raises(BusError, match=f"no router at {endpoint}"):
        ZenohBus(connect=endpoint, give_up=lambda: asked.append(1) or len(asked) >= 2)
    opened: list[ZenohBus] = []
    waiting = threading.Thread(target=lambda: opened.append(ZenohBus(connect=endpoint)))
    waiting.start()
    throughout(lambda: not opened, 0.3, "no bus without a router")
    start("services.router", "--listen", endpoint)
    eventually(lambda: opened, 20.0, "the bus once there is a router")
    waiting.join()
    opened[0].close()
