"""`tandem keys`: an authority of one's own, and a certificate for each process of a robot."""

from __future__ import annotations

import datetime
import ipaddress
from pathlib import Path
from typing import Annotated

import typer
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from services.cli.common import DEFAULT_ROBOT, Robot, refuse
from shared.processes import ROUTER, publisher_named
from shared.wire.access import PARTICIPANTS, common_name

_HOUR = datetime.timedelta(hours=1)
_AUTHORITY_DAYS = 3650
_OWN_ADDRESSES = ("localhost", "127.0.0.1", "::1")


def keys(
    folder: Annotated[Path, typer.Argument(help="Where they go: authority/ and a folder for each process.")],
    only: Annotated[
        list[str] | None, typer.Option(help="Make these only, anew; all that are missing if left out.")
    ] = None,
    days: Annotated[float, typer.Option(min=0.0, help="How long a certificate is valid [days].")] = 365.0,
    name: Annotated[list[str] | None, typer.Option(help="Further host name or address of every process.")] = None,
    robot: Robot = DEFAULT_ROBOT,
) -> None:
    """Make certificates for a closed network; who has a folder of them can be started with `--secure FOLDER/NAME`."""
    known = (ROUTER.name, *PARTICIPANTS)
    for wanted in only or ():
        if wanted not in known:
            refuse(f"--only {wanted}: choose from {', '.join(known)}")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    authority = _Authority(folder / "authority")
    made = []
    for participant in only or known:
        place = folder / participant
        if only or not (place / "certificate.pem").exists():
            addresses = (participant, publisher_named(participant), *_OWN_ADDRESSES, *(name or ()))
            authority.issue(place, common_name(robot, participant), tuple(dict.fromkeys(addresses)), days)
            made.append(participant)
    typer.echo(
        f"made for {', '.join(made) or 'nobody: all are there'}; each folder goes to its owner, authority/ to nobody"
    )


class _Authority:
    """Signs certificates; made where there is none."""

    def __init__(self, folder: Path) -> None:
        self._certificate, self._key = folder / "authority.pem", folder / "key.pem"
        if not self._key.exists():
            folder.mkdir(mode=0o700, exist_ok=True)
            key = ec.generate_private_key(ec.SECP256R1())
            subject = _name("tandem authority")
            builder = _builder(subject, subject, key.public_key(), _AUTHORITY_DAYS)
            builder = builder.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            _write(
                self._certificate, builder.sign(key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM), 0o644
            )
            _write_key(self._key, key)

    def issue(self, folder: Path, common: str, addresses: tuple[str, ...], days: float) -> None:
        """A key, its certificate for both sides of a link, and the authority's certificate, in a folder."""
        signer = serialization.load_pem_private_key(self._key.read_bytes(), None)
        assert isinstance(signer, ec.EllipticCurvePrivateKey)
        issuer = x509.load_pem_x509_certificate(self._certificate.read_bytes()).subject
        key = ec.generate_private_key(ec.SECP256R1())
        usage = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH])
        builder = (
            _builder(_name(common), issuer, key.public_key(), days)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(usage, critical=False)
            .add_extension(
                x509.SubjectAlternativeName([_alternative(address) for address in addresses]), critical=False
            )
        )
        folder.mkdir(mode=0o700, exist_ok=True)
        _write_key(folder / "key.pem", key)
        certificate = builder.sign(signer, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)
        _write(folder / "certificate.pem", certificate, 0o644)
        _write(folder / "authority.pem", self._certificate.read_bytes(), 0o644)


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, days: float
) -> x509.CertificateBuilder:
    now = datetime.datetime.now(datetime.UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        # Clocks of two machines may differ.
        .not_valid_before(now - _HOUR)
        .not_valid_after(now + datetime.timedelta(days=days))
    )


def _name(common: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common)])


def _alternative(address: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(address))
    except ValueError:
        return x509.DNSName(address)


def _write_key(path: Path, key: ec.EllipticCurvePrivateKey) -> None:
    form = (serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    _write(path, key.private_bytes(*form), 0o600)


def _write(path: Path, content: bytes, mode: int) -> None:
    path.touch(mode=mode)
    path.write_bytes(content)
