"""Certificates of the closed network: a process' own, the authority that it trusts, and why it was refused.

Zenoh says the same of a port where nobody listens and of one where a certificate was refused, so the reason is found
out by a handshake of Python's own.
"""

from __future__ import annotations

import os
import re
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path

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
    def of(cls, folder: str) -> Credentials | None:
        """The credentials in a folder; None if none is named.

        Raises:
            BusError: if a file is missing or cannot be read.
        """
        if not folder:
            return None
        found = cls(Path(folder))
        for path in (found.authority, found.certificate, found.key):
            try:
                path.read_bytes()
            except OSError as problem:
                raise BusError(
                    f"--secure {folder}: {path.name}: {problem.strerror}; make it with `tandem keys`"
                ) from None
        return found

    @classmethod
    def given(cls) -> Credentials | None:
        """Those that the environment names, for whoever has no option for them; errors as above."""
        return cls.of(os.environ.get("TANDEM_SECURE", ""))

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
        return {
            f"{prefix}/root_ca_certificate": str(self.authority),
            f"{prefix}/enable_mtls": True,
            f"{prefix}/listen_certificate": str(self.certificate),
            f"{prefix}/listen_private_key": str(self.key),
            f"{prefix}/connect_certificate": str(self.certificate),
            f"{prefix}/connect_private_key": str(self.key),
            f"{prefix}/close_link_on_expiration": True,
        }

    def why_refused(self, endpoint: str) -> str:
        """Why there is no connection to a listener, empty if it would take this certificate or nobody listens."""
        form = _ADDRESS.match(endpoint)
        if form is None:
            return f"{endpoint} is not encrypted, wanted tls/<address>:<port>"
        host, port = form["host"].strip("[]"), int(form["port"])
        try:
            context = ssl.create_default_context(cafile=str(self.authority))
            context.load_cert_chain(self.certificate, self.key)
        except (OSError, ssl.SSLError) as problem:
            return f"the certificate or key in {self.folder} cannot be used ({_words(problem)})"
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
            return f"the certificate of {endpoint} is refused here: {problem.verify_message}"
        except ssl.SSLError as problem:
            return f"{endpoint} refused the certificate in {self.folder}: {_words(problem)}"
        except ConnectionError:
            pass
        return (
            f"{endpoint} ended the connection without a word: has the certificate in {self.folder} expired, or is it "
            "of another network?"
        )


def _words(problem: Exception) -> str:
    """OpenSSL's reason, in words."""
    reason = getattr(problem, "reason", None) or getattr(problem, "strerror", None) or str(problem)
    return str(reason).lower().replace("_", " ")
