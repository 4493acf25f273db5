"""Another machine at the end of a cable that can be cut in either direction: a network namespace of this one.

Both have the same steady clock, so what is noted there can be compared with what happens here.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from types import TracebackType
from typing import Literal, Self

Direction = Literal["there", "back"]
_CHAINS: dict[Direction, tuple[str, str, str]] = {
    "there": ("INPUT", "-i", "--sport"),
    "back": ("OUTPUT", "-o", "--dport"),
}


def unusable() -> str:
    """Why there is no second machine to be had here; empty if there is."""
    if os.geteuid() != 0:
        return "network namespaces want root"
    missing = [name for name in ("ip", "iptables") if shutil.which(name) is None]
    if missing:
        return f"{' and '.join(missing)} not installed (Debian: iproute2, iptables)"
    return ""


class FarMachine:
    """The other machine; a context manager that leaves nothing behind.

    Attributes:
        address: of it, as this machine dials it.
        here: address of this machine, as it dials it.
        within: what a command begins with that is to run there.
    """

    def __init__(self) -> None:
        number = os.getpid() % 16384
        self._name = f"tandem-{number}"
        self._ends = f"tdm{number}h", f"tdm{number}f"
        first = f"10.231.{number // 64}"
        self.here, self.address = f"{first}.{number % 64 * 4 + 1}", f"{first}.{number % 64 * 4 + 2}"
        self.within = ("ip", "netns", "exec", self._name)

    def __enter__(self) -> Self:
        here, far = self._ends
        _do("ip", "netns", "add", self._name)
        try:
            _do("ip", "link", "add", here, "type", "veth", "peer", "name", far, "netns", self._name)
            _do("ip", "addr", "add", f"{self.here}/30", "dev", here)
            _do("ip", "link", "set", here, "up")
            _do(*self.within, "ip", "addr", "add", f"{self.address}/30", "dev", far)
            for name in (far, "lo"):
                _do(*self.within, "ip", "link", "set", name, "up")
        except subprocess.CalledProcessError:
            self._remove()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._remove()

    def _remove(self) -> None:
        _do("ip", "netns", "del", self._name)

    def lose(self, direction: Direction, share: float) -> None:
        """Lose a share [1] of the packets on the way there, or back; 1 cuts it."""
        chain, along, _ = _CHAINS[direction]
        some = () if share >= 1.0 else ("-m", "statistic", "--mode", "random", "--probability", f"{share:g}")
        _do(*self.within, "iptables", "-A", chain, along, self._ends[1], *some, "-j", "DROP")

    def cut(self, but: int) -> None:
        """Lose all packets of both ways at once, but those of a TCP port of this machine."""
        rules = (
            f"-A {chain} {along} {self._ends[1]} -p tcp ! {end} {but} -j DROP" for chain, along, end in _CHAINS.values()
        )
        _do(*self.within, "iptables-restore", "--noflush", told="\n".join(("*filter", *rules, "COMMIT\n")))

    def mend(self) -> None:
        """Lose nothing any more."""
        _do(*self.within, "iptables", "-F")


def _do(*command: str, told: str = "") -> None:
    subprocess.run(command, check=True, capture_output=True, timeout=30.0, input=told.encode())
