"""Direct links of a closed network take a renewed certificate, and another authority, over while they run."""

from __future__ import annotations

import shutil
import socket
import ssl
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from threading import enumerate as enumerate_threads

import pytest

from shared.topics import COMMAND_EE_TWIST, WRENCH_EXTERNAL
from shared.wire.links import Links
from shared.wire.zenoh import ZenohBus
from tests.conftest import StartProcess
from tests.faults.test_renewal import Routed, in_file, renew
from tests.support.closed import enter, make, refused
from tests.support.ports import free_port
from tests.support.wait import eventually

pytestmark = pytest.mark.processes
OWNERS = ("wrench", "controller")
SAID = dict(zip(OWNERS, (WRENCH_EXTERNAL.key, COMMAND_EE_TWIST.key), strict=True))
PATIENCE = 30.0  # [s]


class Pair:
    """Two participants of the chain with a direct link, who tell each other something.

    Attributes:
        ports: where each listens, by owner.
        buses: of each.
        heard: by key, what the other one was told.
    """

    def __init__(self, router: Routed, keys: Path, open_: ExitStack) -> None:
        self.router = router
        self.ports = {name: str(free_port()) for name in OWNERS}
        pattern = "tls/127.0.0.1:{name}"
        self.links = {name: Links(port, tuple(self.ports.values()), pattern) for name, port in self.ports.items()}
        self.buses: dict[str, ZenohBus] = {
            name: open_.enter_context(closing(enter(router.endpoint, keys / name, self.links[name]))) for name in OWNERS
        }
        self.heard: dict[str, list[bytes]] = {key: [] for key in SAID.values()}
        for reader, (said, heard) in zip(reversed(OWNERS), self.heard.items(), strict=True):
            self.buses[reader].subscribe(said, heard.append, lambda behind: None)
        self._count = 0

    def talks(self) -> bool:
        """Whether a message of each that is said now reaches the other."""
        self._count += 1
        message = str(self._count).encode()
        for name, bus in self.buses.items():
            bus.publish(SAID[name], message)
        return all(message in heard for heard in self.heard.values())

    def linked(self) -> bool:
        return all(all(bus.links().values()) for bus in self.buses.values())

    def works(self) -> None:
        eventually(lambda: self.linked() and self.talks(), PATIENCE, "both are linked and hear each other")

    def shows(self, name: str, certificate: bytes) -> None:
        def shown() -> bool:
            try:
                return ssl.PEM_cert_to_DER_cert(ssl.get_server_certificate(("127.0.0.1", int(self.ports[name])))) == (
                    certificate
                )
            except OSError:
                return False

        eventually(shown, PATIENCE, f"{name} shows another certificate")

    def doubles(self) -> bool:
        return any(len(heard) != len(set(heard)) for heard in self.heard.values())


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    return make(tmp_path / "keys")


@pytest.fixture
def pair(start: StartProcess, keys: Path) -> Iterator[Pair]:
    router = Routed(start, keys)
    with ExitStack() as open_:
        found = Pair(router, keys, open_)
        found.works()
        yield found


@pytest.mark.parametrize("name", OWNERS)
def test_who_has_another_certificate_shows_it_and_both_hear_each_other_again(pair: Pair, keys: Path, name: str) -> None:
    renew(keys, name)
    pair.buses[name].link_anew()
    pair.shows(name, in_file(keys / name))
    pair.works()
    assert not pair.doubles()


def test_with_another_authority_whoever_has_the_old_one_is_out(pair: Pair, keys: Path, tmp_path: Path) -> None:
    stolen = shutil.copytree(keys / "controller", tmp_path / "stolen")
    make(keys, "--revoke")
    pair.router.process.wait_for_output("renewed")
    for bus in pair.buses.values():
        bus.link_anew()
    pair.works()
    for name, port in pair.ports.items():
        pair.shows(name, in_file(keys / name))
        context = ssl._create_unverified_context()
        context.load_cert_chain(stolen / "certificate.pem", stolen / "key.pem")
        assert refused(int(port), context)
    assert not pair.doubles()


def test_links_are_made_anew_once_the_router_is_back(pair: Pair, start: StartProcess, keys: Path) -> None:
    """Certificates are renewed together, and the router listens anew at the same time."""
    bus = pair.buses["controller"]
    pair.router.process.kill()
    bus.link_anew()
    eventually(lambda: not bus.connected(), PATIENCE, "the router is gone")
    assert bus.links() == {pair.ports["wrench"]: False}
    bus.publish(COMMAND_EE_TWIST.key, b"nobody hears it, and it is no error")
    again = start("services.router", "--listen", pair.router.endpoint, "--secure", str(keys / "router"))
    again.wait_for_output("listening", 60.0)
    pair.works()


def test_a_bus_is_closed_in_the_middle(pair: Pair) -> None:
    pair.router.process.kill()
    bus = pair.buses["wrench"]
    bus.link_anew()
    eventually(lambda: not bus.connected(), PATIENCE, "the session is closed")
    bus.close()
    eventually(
        lambda: not any(thread.name == "link anew" for thread in enumerate_threads()), PATIENCE, "it is given up"
    )
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", int(pair.ports["wrench"]))) != 0
