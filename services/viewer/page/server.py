"""The person's page: the sentence and STOP above the picture, and above the hands."""

from __future__ import annotations

import math
import secrets
import time
from collections.abc import Callable, Mapping
from http import HTTPStatus
from pathlib import Path
from typing import Any

from services.viewer.heard import Ears
from services.viewer.page.actions import Actions
from services.viewer.page.guarded import NAMES, OWN_HEADER, Guarded, GuardedServer
from services.viewer.page.picture import Picture
from services.viewer.page.shown import shown
from services.viewer.sentence import Kind, Sentence, say
from shared.loop.config import Misconfigured
from shared.topics import CONTROL_STATUS, STATE_ROBOT
from shared.wire.client import Client
from shared.wire.credentials import Credentials
from shared.wire.latch import Latch
from shared.wire.zenoh import ZenohBus

_LOOKS_AGAIN = 5.0
"""Time [s] within which a page that is looked at asks again; one in the background asks once a second."""
HEARD_WITHIN = 0.5
"""Time [s] after which who begins to look is told of everybody: until then most is not listened to."""
Shown = Callable[[str], Mapping[str, Any]]
"""What the page shows, given the name of this start of it."""
_STATIC = Path(__file__).with_name("static")
_PAGE = ("page.html", "text/html; charset=utf-8")
_PAGES = {
    "/": _PAGE,
    "/hands": _PAGE,
    "/page.css": ("page.css", "text/css"),
    **{f"/{name}": (name, "text/javascript") for name in ("enable.js", "hands.js", "page.js", "talk.js")},
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; connect-src 'self'; "
    "frame-src {pictures}; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)


class PageServer:
    """Serves the page and, one port above, the picture in it, in threads of its own until it is closed.

    Args:
        host: address to listen on; browsers are let in that call this machine 127.0.0.1 or localhost.
        port: of the page; 0 is any.
        source: address of a drawing of this machine (``rerun+http://127.0.0.1:PORT/proxy``), or a recording (.rrd).
        shown: what the page shows.
        actions: what a person may do from it; None for a recording, which can only be looked at.

    Attributes:
        port: of the page.
        url: for a browser on this machine.

    Raises:
        Misconfigured: one of the ports is not to be had.
    """

    def __init__(self, host: str, port: int, source: str | Path, shown: Shown, actions: Actions | None = None) -> None:
        self._page, self._picture = _pair(host, port, source, shown, actions)
        self._page.reads = self._picture.reads
        self.port = self._page.port
        self.url = f"http://127.0.0.1:{self.port}/"

    @property
    def watched(self) -> bool:
        """Whether a browser has the page open."""
        return self._page.watched

    def close(self) -> None:
        """End it."""
        self._page.close()
        self._picture.close()


def _pair(
    host: str, port: int, source: str | Path, shown: Shown, actions: Actions | None, attempts: int = 20
) -> tuple[_Page, Picture]:
    """Both servers, on ports side by side; if any will do, others are tried when the upper one is taken."""
    page = _Page(host, port, shown, actions)
    try:
        return page, Picture(host, page.port + 1, source)
    except Misconfigured:
        page.close()
        if port or attempts == 1:
            raise
    return _pair(host, port, source, shown, actions, attempts - 1)


def served(
    host: str, port: int, source: str, ears: Ears, bus: ZenohBus, robot: str, credentials: Credentials | None
) -> PageServer:
    """The page of a running robot: what is heard, and what a person may do.

    Raises:
        Misconfigured: as the class.
    """
    client = Client(bus, credentials=credentials)
    gate, controller = (ears.subscriptions[topic.key] for topic in (STATE_ROBOT, CONTROL_STATUS))
    actions = Actions(client, Latch(client, gate, controller))

    def now(run: str) -> Mapping[str, Any]:
        known = ears.known()
        cut_off = "" if bus.connected() else "the router is gone"
        return shown(run, robot, say(known, cut_off), known, actions.forbidden)

    return PageServer(host, port, source, now, actions)


def recorded_page(host: str, port: int, path: Path, text: str) -> PageServer:
    """The page of a recording (.rrd), with a line about it: it is looked at, and nothing is done.

    Raises:
        Misconfigured: as the class.
    """
    about = Sentence(text, Kind.FREE)
    return PageServer(host, port, path, lambda run: shown(run, "", about, {}, {}))


class _Page(GuardedServer):
    def __init__(self, host: str, port: int, shown: Shown, actions: Actions | None) -> None:
        self.run, self.asked_at = secrets.token_urlsafe(12), -math.inf
        self.shown, self.actions, self.reads = shown, actions, ""
        self.pages = {path: ((_STATIC / name).read_bytes(), kind) for path, (name, kind) in _PAGES.items()}
        super().__init__(host, port, _Handler)

    @property
    def watched(self) -> bool:
        """Whether it has been asked lately for what it shows."""
        return time.monotonic() - self.asked_at < _LOOKS_AGAIN


class _Handler(Guarded):
    server: _Page
    urgent = ("/stop",)

    def get(self, path: str) -> None:
        if path == "/state":
            begins = not self.server.watched
            self.server.asked_at = time.monotonic()
            if begins and self.server.actions is not None:
                time.sleep(HEARD_WITHIN)
            acts = {"acts": self.server.actions is not None, "reads": self.server.reads}
            self.tell({**self.server.shown(self.server.run), **acts})
        elif path in self.server.pages:
            content, kind = self.server.pages[path]
            policy = _POLICY.format(pictures=" ".join(f"http://{name}:{self.own_port + 1}" for name in NAMES))
            self.answer(content, kind, headers={"Content-Security-Policy": policy})
        else:
            self.refuse(HTTPStatus.NOT_FOUND, "there is no such page")

    def post(self, path: str) -> None:
        actions = self.server.actions
        if actions is None or path not in actions.by_path:
            return self.refuse(HTTPStatus.NOT_FOUND, "there is no such thing to be done here")
        if OWN_HEADER not in self.headers:
            return self.refuse(HTTPStatus.FORBIDDEN, "only the page that is served here may ask this")
        # A stop says nothing further: there is nothing to be refused about it.
        asked = {} if path in self.urgent else self.body()
        if asked is not None:
            self.tell(actions.by_path[path](asked)._asdict())
