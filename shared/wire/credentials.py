"""Certificates of the closed network: a process' own, the authority that it trusts, and why it was refused.

Zenoh says the same of a port where nobody listens and of one where a certificate was refused, so the reason is found
out by a handshake of Python's own. What is wrong with a process' own files is said before anything is dialled.
"""

from __future__ import annotations

import os
import re
import socket
import ssl
import time
from dataclasses import dataclass
from pathlib import Path

from shared.wire.access import common_name
from shared.wire.certificate import Certificate, read_certificate
from shared.wire.endpoint import BusError

_PROBE = 1.0  # [s] for a handshake, and for the answer to it
_ADDRESS = re.compile(r"tls/(?P<host>\[[^\]]+\]|[^/:?#]+):(?P<port>\d+)")


@dataclass(frozen=True)
class Credentials:
    """The folder that a process was given.

    Attributes:
        folder: holds ``authority.pem``, ``certificate.pem`` and ``key.pem``.
    """

    folder: Path

    @classmethod
    def of(cls, folder: str, robot: str = "", participant: str = "") -> Credentials | None:
        """The credentials in a folder; None if none is named.

        Args:
            folder: as the user names it.
            robot: that the certificate has to be for, if it matters.
            participant: whose it has to be, if it matters.

        Raises:
            BusError: if a file is missing or cannot be used, or the certificate has expired or is somebody else's.
        """
        if not folder:
            return None
        found = cls(Path(folder))
        own = found.own()
        found.check_time(own)
        if participant and own.name != (wanted := common_name(robot, participant)):
            raise BusError(f"--secure {folder}: the certificate is of {own.name}, wanted that of {wanted}")
        if robot and not own.name.startswith(f"{robot}."):
            raise BusError(f"--secure {folder}: the certificate is of {own.name}, which may do nothing with {robot}")
        return found

    @classmethod
    def given(cls, robot: str = "") -> Credentials | None:
        """Those that the environment names, for whoever has no option for them; errors as above."""
        return cls.of(os.environ.get("TANDEM_SECURE", ""), robot)

    def own(self) -> Certificate:
        """What the certificate says.

        Raises:
            BusError: if a file is missing, or they do not belong together.
        """
        for path in self._files:
            try:
                path.read_bytes()
            except OSError as problem:
                raise BusError(
                    f"--secure {self.folder}: {path.name}: {problem.strerror}; make it with `tandem keys`"
                ) from None
        try:
            return read_certificate(*self._files)
        except OSError as problem:
            raise BusError(
                f"--secure {self.folder}: its files cannot be used ({_words(problem)}); make them with `tandem keys`"
            ) from None

    def check_time(self, own: Certificate) -> None:
        """Hold the certificate against the clock.

        Raises:
            BusError: it has expired.
        """
        if own.expired(time.time()):
            raise BusError(
                f"--secure {self.folder}: the certificate of {own.name} expired on {own.end}; make another one with "
                "`tandem keys`"
            )

    def check_endpoint(self, option: str, endpoint: str) -> None:
        """Hold an endpoint against what a closed network needs.

        Raises:
            BusError: nothing is encrypted there.
        """
        if not _ADDRESS.match(endpoint):
            raise BusError(f"{option} {endpoint}: with certificates ({self.folder}) wanted tls/<address>:<port>")

    def stamp(self) -> tuple[tuple[int, int, int], ...]:
        """Another one whenever one of the files was written or replaced."""
        found = []
        for path in self._files:
            try:
                about = path.stat()
            except OSError:
                continue
            found.append((about.st_ino, about.st_mtime_ns, about.st_size))
        return tuple(found)

    @property
    def _files(self) -> tuple[Path, Path, Path]:
        return self.authority, self.certificate, self.key

    @property
    def authority(self) -> Path:
        """Certificate of the authority whose certificates are trusted."""
        return self.folder / "authority.pem"

    @property
    def certificate(self) -> Path:
        """Certificate of the process."""
        return self.folder / "certificate.pem"

    @property
    def key(self) -> Path:
        """Its private key."""
        return self.folder / "key.pem"

    def settings(self) -> dict[str, object]:
        """Settings of a Zenoh session: both sides of every link show a certificate, and no link outlives one."""
        prefix = "transport/link/tls"
        authority, certificate, key = (str(path.absolute()) for path in self._files)
        return {
            f"{prefix}/root_ca_certificate": authority,
            f"{prefix}/enable_mtls": True,
            f"{prefix}/listen_certificate": certificate,
            f"{prefix}/listen_private_key": key,
            f"{prefix}/connect_certificate": certificate,
            f"{prefix}/connect_private_key": key,
            f"{prefix}/close_link_on_expiration": True,
        }

    def why_refused(self, endpoint: str) -> str:
        """Why there is no connection to a listener, empty if it would take this certificate or nobody listens."""
        form = _ADDRESS.match(endpoint)
        assert form is not None
        host, port = form["host"].strip("[]"), int(form["port"])
        try:
            self.check_time(self.own())
        except BusError as problem:
            return str(problem)
        context = ssl.create_default_context(cafile=str(self.authority))
        context.load_cert_chain(self.certificate, self.key)
        try:
            plain = socket.create_connection((host, port), _PROBE)
        except OSError:
            return ""
        try:
            with plain, context.wrap_socket(plain, server_hostname=host) as secured:
                # What the other side thinks of this certificate it says after the handshake only.
                secured.settimeout(_PROBE)
                if secured.recv(1):
                    return ""
        except TimeoutError:
            return ""
        except ssl.SSLCertVerificationError as problem:
            return f"the certificate of {endpoint} is refused here: {_meaning(problem)}"
        except ssl.SSLError as problem:
            return f"{endpoint} refused the certificate in {self.folder}: {_meaning(problem)}"
        except ConnectionError:
            pass
        return (
            f"{endpoint} ended the connection without a word: has the certificate in {self.folder} expired, or is it "
            "of another network?"
        )


def _words(problem: Exception) -> str:
    """OpenSSL's reason, in words."""
    said = (getattr(problem, name, None) for name in ("verify_message", "reason", "strerror"))
    return str(next(filter(None, said), problem)).lower().replace("_", " ")


_MEANINGS = {
    "mismatch": "it does not name that address: `tandem keys --name` adds one",
    "expired": "make another one with `tandem keys`, if the clocks of both machines are right",
    "not yet valid": "are the clocks of both machines right?",
    "signature": "it is of another authority",
    "issuer": "it is of another authority",
    "unknown ca": "it is of another authority",
    "self-signed": "it is of another authority",
    "decrypt error": "it is of another authority",
}


def _meaning(problem: Exception) -> str:
    """OpenSSL's reason, and what it means to somebody with certificates of `tandem keys`."""
    words = _words(problem)
    meaning = next((meaning for part, meaning in _MEANINGS.items() if part in words), "")
    return f"{words} ({meaning})" if meaning else words
