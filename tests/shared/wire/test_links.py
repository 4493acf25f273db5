"""Where the processes of the chain listen, and whom they dial."""

from __future__ import annotations

import pytest

from shared.processes import LINKED, PROCESSES
from shared.wire.links import NONE, SOCKETS, NoLinks, links_of, usual_links

ROUTER = "tcp/127.0.0.1:7447"


def listens(robot: str = "tiago", router: str = ROUTER) -> str:
    links = links_of("wrench", LINKED, SOCKETS, robot, router)
    assert links is not None
    return links.listen


def test_of_each_two_the_later_one_dials_where_the_earlier_one_listens() -> None:
    """Never both: of a session with two connections one end may give up both and the other only one."""
    links = [links_of(name, LINKED, SOCKETS, "tiago", ROUTER) for name in LINKED]
    listens: list[str] = []
    for own in links:
        assert own is not None
        assert own.dial == tuple(listens)
        assert own.others == tuple(name for name in LINKED if name != own.own)
        listens.append(own.listen)
    assert len(set(listens)) == len(LINKED)


def test_robots_and_routers_are_kept_apart_and_spellings_are_not() -> None:
    assert (
        len({listens(), listens("reem"), listens(router="tcp/127.0.0.1:7448"), listens(router="tcp/127.0.0.2:7447")})
        == 4
    )
    assert listens() == listens(router="tcp/localhost:7447") == listens(router="tcp/127.0.0.1:7447#iface=lo")


def test_a_socket_has_a_path_that_the_system_takes() -> None:
    assert len(listens("r" * 500).removeprefix("unixsock-stream/")) < 100


def test_a_pattern_names_each_process() -> None:
    links = links_of("wrench", ("robot", "wrench"), "tls/{name}:7448", "tiago", "tls/router:7447")
    assert links is not None
    assert (links.listen, links.dial) == ("tls/wrench:7448", ("tls/robot:7448",))


def test_nobody_else_is_linked_nor_anybody_unasked() -> None:
    assert links_of("experiment", LINKED, SOCKETS, "tiago", ROUTER) is None
    assert links_of("wrench", LINKED, NONE, "tiago", ROUTER) is None


@pytest.mark.parametrize("router", ["tcp/192.168.0.2:7447", "tls/127.0.0.1:7447"])
def test_sockets_are_for_one_machine_without_certificates(router: str) -> None:
    assert usual_links(router) == NONE
    with pytest.raises(NoLinks, match=f"--links sockets: .* the router is at {router}"):
        links_of("wrench", LINKED, SOCKETS, "tiago", router)


def test_a_pattern_without_a_name_is_refused() -> None:
    with pytest.raises(NoLinks, match=r"--links tcp/1.2.3.4:1: wanted an endpoint with \{name\}"):
        links_of("wrench", LINKED, "tcp/1.2.3.4:1", "tiago", ROUTER)


def test_no_more_processes_than_an_identity_has_places_for() -> None:
    assert len(LINKED) < 16
    assert {process.name for process in PROCESSES if process.linked} >= {"wrench", "controller", "base", "task", "sim"}
