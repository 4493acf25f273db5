"""The closed network over real sessions: every certificate, every key, and what is said to whoever is refused."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from shared.topics import QUERIES, STOP, TOPICS
from shared.wire.access import PARTICIPANTS, may_ask, may_publish, may_serve
from shared.wire.bus import NoReply
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError
from shared.wire.links import Links
from shared.wire.zenoh import ZenohBus
from tests.conftest import StartProcess
from tests.support.closed import enter, make
from tests.support.ports import free_port
from tests.support.wait import eventually

pytestmark = pytest.mark.processes
OFTEN = 3
"""Times that a query is asked which nobody may answer: one could be lost."""


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("keys") / "tiago")


@pytest.fixture
def endpoint(start: StartProcess, keys: Path) -> Iterator[str]:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    start("services.router", "--listen", endpoint, "--secure", str(keys / "router")).wait_for_output("listening")
    yield endpoint


def all_in(endpoint: str, keys: Path) -> Iterator[dict[str, ZenohBus]]:
    with ExitStack() as open_:
        yield {name: open_.enter_context(closing(enter(endpoint, keys / name))) for name in PARTICIPANTS}


everybody = pytest.fixture(all_in)
others = pytest.fixture(all_in)
"""A session of each certificate, and another one: what a session says to itself asks nobody."""


def test_under_each_key_is_heard_who_may_speak_there_and_nobody_else(
    everybody: dict[str, ZenohBus], others: dict[str, ZenohBus]
) -> None:
    heard: set[tuple[str, str]] = set()
    for topic in TOPICS:
        others["viewer"].subscribe(topic.key, lambda payload, key=topic.key: heard.add((payload.decode(), key)))
    wanted = {(name, topic.key) for name in PARTICIPANTS for topic in TOPICS if may_publish(name, topic)}

    def all_say() -> bool:
        for topic in TOPICS:
            for name, bus in everybody.items():
                bus.publish(topic.key, name.encode())
        return heard >= wanted

    eventually(all_say, 40.0, lambda: f"heard: {sorted(wanted - heard)}")
    assert heard == wanted


def test_each_query_is_answered_by_its_server_to_whoever_may_ask(
    everybody: dict[str, ZenohBus], others: dict[str, ZenohBus]
) -> None:
    answered: dict[str, set[str]] = {query.key: set() for query in QUERIES}
    for name, bus in others.items():
        for query in QUERIES:
            # Simulation, mock and robot all may answer for the robot: one of a kind is there at a time.
            if name not in ("mock", "robot"):
                bus.serve(query.key, lambda _, reply, name=name: reply(name.encode()))
    for query in QUERIES:
        servers = {name for name in PARTICIPANTS if may_serve(name, query)} - {"mock", "robot"}
        eventually(lambda key=query.key: everybody["operator"].query(key, b"", 2.0), 20.0, f"{query.key} is answered")
        for name, bus in everybody.items():
            for _ in range(1 if may_ask(name, query) else OFTEN):
                try:
                    answered[query.key].add(bus.query(query.key, b"", 2.0 if may_ask(name, query) else 0.3).decode())
                    assert may_ask(name, query), (name, query.key)
                except NoReply:
                    assert not may_ask(name, query), (name, query.key)
        assert answered[query.key] == servers


def test_whoever_is_refused_is_told_why(endpoint: str, keys: Path, tmp_path: Path) -> None:
    with pytest.raises(BusError, match="is a closed network: name your certificates"):
        ZenohBus("tiago", endpoint, lambda: True)
    with pytest.raises(BusError, match="refused here"):
        enter(endpoint, make(tmp_path / "foreign") / "operator")
    short = make(tmp_path / "short", "--only", "operator", "--days", "0.0001")
    for file in ("authority.pem", "key.pem"):
        (short / "authority" / file).write_bytes((keys / "authority" / file).read_bytes())
    make(short, "--only", "operator", "--days", "0")
    with pytest.raises(BusError, match=r"the certificate of tiago.operator expired on"):
        enter(endpoint, short / "operator")
    with pytest.raises(BusError, match=r"no router at tls/127.0.0.1"):
        enter(f"tls/127.0.0.1:{free_port()}", keys / "operator", within=0.0)
    with pytest.raises(BusError, match=r"key.pem: No such file or directory; make it with `tandem keys`"):
        (tmp_path / "empty").mkdir()
        for file in ("authority.pem", "certificate.pem"):
            (tmp_path / "empty" / file).touch()
        Credentials.of(str(tmp_path / "empty"))


def test_another_robot_s_certificate_hears_and_stops_nothing(
    endpoint: str, keys: Path, everybody: dict[str, ZenohBus]
) -> None:
    make(keys, "--robot", "reem", "--only", "viewer", "--renew")
    heard: list[bytes] = []
    stops: list[bytes] = []
    with closing(enter(endpoint, keys / "viewer")) as foreign:
        foreign.subscribe(STOP.key, heard.append)
        everybody["robot"].subscribe(STOP.key, stops.append)

        def stopped() -> bool:
            foreign.publish(STOP.key, b"foreign")
            everybody["operator"].publish(STOP.key, b"operator")
            return len(stops) > 10

        eventually(stopped, 20.0, "the operator's stop is heard")
    assert set(stops) == {b"operator"}
    assert set(heard) <= {b"foreign"}


def test_a_direct_link_asks_for_certificates_too(endpoint: str, keys: Path) -> None:
    """Whoever dials a process of the chain itself is held against the same rules as at the router."""
    ports = tuple(str(free_port()) for _ in range(2))
    pattern = "tls/127.0.0.1:{name}"
    stops: list[bytes] = []
    heard: list[bytes] = []
    with ExitStack() as open_:
        robot = open_.enter_context(closing(enter(endpoint, keys / "sim", Links(ports[0], ports, pattern))))
        controller = open_.enter_context(closing(enter(endpoint, keys / "controller", Links(ports[1], ports, pattern))))
        intruder = open_.enter_context(closing(enter(f"tls/127.0.0.1:{ports[0]}", keys / "viewer")))
        robot.subscribe("command/ee_twist", heard.append)
        robot.subscribe(STOP.key, stops.append)
        eventually(lambda: controller.links() == {ports[0]: True}, 20.0, "the link stands")

        def commanded() -> bool:
            intruder.publish("command/ee_twist", b"intruder")
            intruder.publish(STOP.key, b"intruder")
            controller.publish("command/ee_twist", b"controller")
            return len(heard) > 10

        eventually(commanded, 20.0, "the controller is heard")
    assert set(heard) == {b"controller"}
    assert not stops
