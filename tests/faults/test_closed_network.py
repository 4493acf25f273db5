"""The closed network over real sessions: every certificate, every key, and what is said to whoever is refused."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
import zenoh

from shared.topics import QUERIES, STOP, TOPICS
from shared.wire.access import PARTICIPANTS, common_name, may_ask, may_publish, may_serve
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError
from shared.wire.links import Links
from shared.wire.zenoh import ZenohBus
from tests.support.closed import enter, make, refused, session, strangers
from tests.support.ports import free_port
from tests.support.processes import Processes
from tests.support.wait import eventually

pytestmark = pytest.mark.processes
ROBOTS = ("tiago", "reem")
ZENOHD = os.environ.get("TANDEM_ZENOHD", "")
"""The standard router, held against the same cases where there is one."""
WHILE = 3.0  # [s] for an answer; whoever may not ask waits for all of it


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys")
    make(folder / "tiago")
    shutil.copytree(folder / "tiago" / "authority", folder / "reem" / "authority")
    make(folder / "reem", "--robot", "reem")
    return folder


@pytest.fixture(
    scope="module",
    params=[
        "options",
        "file",
        pytest.param("zenohd", marks=pytest.mark.skipif(not ZENOHD, reason="TANDEM_ZENOHD names no zenohd 1.10.2")),
    ],
)
def endpoint(keys: Path, request: pytest.FixtureRequest) -> Iterator[str]:
    """Where a router of the closed network listens: this project's, the same with the file that it prints, Zenoh's."""
    port = free_port()
    endpoint = f"tls/127.0.0.1:{port}"
    both = [option for robot in ROBOTS for option in ("--robot", robot)]
    options = ["--listen", endpoint, "--secure", f"{keys}/tiago/router", *both]
    file = keys / f"{request.param}.json5"
    with Processes(keys) as processes:
        if request.param != "options":
            printed = processes.start("services.router", *options, "--print-config")
            assert printed.wait(60.0) == 0
            file.write_text(printed.output)
        if request.param == "zenohd":
            processes.callback(ended, subprocess.Popen([ZENOHD, "-c", file], env={"RUST_LOG": "off"}))
            eventually(lambda: listens(port), 60.0, "zenohd listens")
        else:
            router = processes.start(
                "services.router", *(options if request.param == "options" else ("--config", str(file)))
            )
            router.wait_for_output("listening", 60.0)
        yield endpoint


def ended(process: subprocess.Popen) -> None:
    process.terminate()
    process.wait()


def listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def sessions(endpoint: str, keys: Path) -> Iterator[dict[str, zenoh.Session]]:
    """A session of each certificate of two robots, by its common name; no table of this project is asked there."""
    with ExitStack() as open_:
        yield {
            common_name(robot, name): open_.enter_context(session(endpoint, keys / robot / name))
            for robot in ROBOTS
            for name in PARTICIPANTS
        }


everybody = pytest.fixture(sessions)
askers = pytest.fixture(sessions)
"""Once more: what a session asks itself asks nobody."""


@pytest.fixture
def witness(endpoint: str, keys: Path) -> Iterator[dict[str, zenoh.Session]]:
    """By robot, one session more: what a session says to itself asks nobody."""
    with ExitStack() as open_:
        yield {robot: open_.enter_context(session(endpoint, keys / robot / "viewer")) for robot in ROBOTS}


def may_say(name: str) -> set[str]:
    """The keys that a participant may publish under, without the robot."""
    said = {topic.key for topic in TOPICS if may_publish(name, topic)}
    if name not in ("operator", "viewer", "page"):
        said |= {f"health/{name}", f"setup/{name}"}
    return said | ({"beat/1"} if name in ("sim", "mock", "robot") else set())


KEYS = (
    *(topic.key for topic in TOPICS),
    *(query.key for query in QUERIES),
    *(f"{kind}/{name}" for kind in ("health", "setup", "alive") for name in (*PARTICIPANTS, "router")),
    *("beat/1", "unheard/of", "**", "*/*", "command/*", "health/*"),
)


def test_under_each_key_is_heard_who_may_speak_there_and_nobody_else(
    everybody: dict[str, zenoh.Session], witness: dict[str, zenoh.Session]
) -> None:
    heard: set[tuple[str, str]] = set()
    for robot, session_ in witness.items():
        session_.declare_subscriber(
            f"{robot}/**",
            lambda sample: heard.add((sample.attachment.to_string(), str(sample.key_expr))),
        )
    wanted = {
        (common_name(robot, name), f"{robot}/{key}")
        for robot in ROBOTS
        for name in PARTICIPANTS
        for key in may_say(name)
    }

    def all_say() -> bool:
        for name, session_ in everybody.items():
            for robot in ROBOTS:
                for key in KEYS:
                    session_.put(f"{robot}/{key}", b"", attachment=name)
                    if "*" not in key:
                        session_.delete(f"{robot}/{key}", attachment=name)
        return heard >= wanted

    eventually(all_say, 60.0, lambda: f"not heard: {sorted(wanted - heard)}")
    assert heard == wanted


def test_a_token_is_seen_of_whoever_it_names_and_of_nobody_else(
    everybody: dict[str, zenoh.Session], witness: dict[str, zenoh.Session]
) -> None:
    # A token ends with its last reference.
    held = [
        session_.liveliness().declare_token(f"{robot}/alive/{name}/{session_.zid()}")
        for session_ in everybody.values()
        for robot in ROBOTS
        for name in PARTICIPANTS
    ]
    wanted = {
        f"{robot}/alive/{name}/{everybody[common_name(robot, name)].zid()}" for robot in ROBOTS for name in PARTICIPANTS
    }

    def seen(whose: str, by: str) -> set[str]:
        replies = witness[by].liveliness().get(f"{whose}/alive/*/*", timeout=WHILE)
        return {str(reply.ok.key_expr) for reply in replies if reply.ok is not None}

    for robot, other in (ROBOTS, ROBOTS[::-1]):
        own = {key for key in wanted if key.startswith(f"{robot}/")}
        eventually(lambda robot=robot, own=own: seen(robot, robot) >= own, 30.0, "every token that may be is seen")
        assert seen(robot, by=robot) == own
        assert not seen(robot, by=other)
    assert len(held) > len(wanted)


def test_each_query_is_answered_by_its_server_to_whoever_may_ask(
    everybody: dict[str, zenoh.Session], askers: dict[str, zenoh.Session]
) -> None:
    keys = [*(query.key for query in QUERIES), "unheard/of", "**"]
    ran: set[tuple[str, str]] = set()

    def serve(name: str, session_: zenoh.Session, key: str) -> None:
        def on_query(query: zenoh.Query) -> None:
            ran.add((name, key))
            query.reply(key, name.encode())
            query.drop()

        session_.declare_queryable(key, on_query)

    for name, session_ in everybody.items():
        for robot in ROBOTS:
            for key in keys:
                serve(name, session_, f"{robot}/{key}")
    able = {
        (f"{robot}/{query.key}", common_name(robot, name))
        for robot in ROBOTS
        for query in QUERIES
        for name in PARTICIPANTS
        if may_serve(name, query)
    }
    wanted = {
        (common_name(robot, asker), key, server)
        for robot in ROBOTS
        for query in QUERIES
        for asker in PARTICIPANTS
        if may_ask(asker, query)
        for key, server in able
        if key == f"{robot}/{query.key}"
    }
    answered: set[tuple[str, str, str]] = set()

    def all_ask() -> bool:
        asked = [
            (name, f"{robot}/{key}", session_.get(f"{robot}/{key}", target=zenoh.QueryTarget.ALL, timeout=WHILE))
            for name, session_ in askers.items()
            for robot in ROBOTS
            for key in keys
        ]
        for name, key, replies in asked:
            answered.update((name, key, reply.ok.payload.to_string()) for reply in replies if reply.ok is not None)
        return answered >= wanted

    eventually(all_ask, 60.0, lambda: f"not answered: {sorted(wanted - answered)}")
    assert answered == wanted
    assert {(name, key) for name, key in ran if "*" not in key} == {(server, key) for key, server in able}
    # Within its own session a server may hear by any name what was meant for it.
    assert {name for name, _ in ran} == {server for _, server in able}


def test_whoever_is_refused_is_told_why(endpoint: str, keys: Path, tmp_path: Path) -> None:
    with pytest.raises(BusError, match="is a closed network: name your certificates"):
        ZenohBus("tiago", endpoint, lambda: True)
    with pytest.raises(BusError, match="refused here"):
        enter(endpoint, make(tmp_path / "foreign") / "operator")
    short = make(tmp_path / "short", "--only", "operator", "--days", "0.0001")
    for file in ("authority.pem", "key.pem"):
        (short / "authority" / file).write_bytes((keys / "tiago" / "authority" / file).read_bytes())
    make(short, "--only", "operator", "--days", "0")
    with pytest.raises(BusError, match=r"the certificate of tiago.operator expired on"):
        enter(endpoint, short / "operator")
    with pytest.raises(BusError, match=r"no router at tls/127.0.0.1"):
        enter(f"tls/127.0.0.1:{free_port()}", keys / "tiago" / "operator", within=0.0)
    with pytest.raises(BusError, match=r"key.pem: No such file or directory; make it with `tandem keys`"):
        (tmp_path / "empty").mkdir()
        for file in ("authority.pem", "certificate.pem"):
            (tmp_path / "empty" / file).touch()
        Credentials.of(str(tmp_path / "empty"))


def test_strangers_get_in_nowhere(endpoint: str, keys: Path, tmp_path: Path) -> None:
    """Neither at the router nor at a process of the chain: no certificate, another authority's, an expired one."""
    port = free_port()
    names = (str(port), "unused")
    with closing(enter(endpoint, keys / "tiago" / "sim", Links(names[0], names, "tls/127.0.0.1:{name}"))):
        for there in (port, int(endpoint.rpartition(":")[2])):
            for context in strangers(keys / "tiago", tmp_path / str(there)).values():
                assert refused(there, context)


def test_a_direct_link_asks_for_certificates_too(endpoint: str, keys: Path) -> None:
    """Whoever dials a process of the chain itself is held against the same rules as at the router."""
    ports = tuple(str(free_port()) for _ in range(2))
    pattern = "tls/127.0.0.1:{name}"
    stops: list[bytes] = []
    heard: list[bytes] = []
    with ExitStack() as open_:
        robot = open_.enter_context(closing(enter(endpoint, keys / "tiago" / "sim", Links(ports[0], ports, pattern))))
        controller = open_.enter_context(
            closing(enter(endpoint, keys / "tiago" / "controller", Links(ports[1], ports, pattern)))
        )
        intruder = open_.enter_context(closing(enter(f"tls/127.0.0.1:{ports[0]}", keys / "tiago" / "viewer")))
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
