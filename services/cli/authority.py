"""A small authority of one's own: it signs the certificates of a closed network and says which are to be made anew."""

from __future__ import annotations

import datetime
import ipaddress
import os
from dataclasses import dataclass
from pathlib import Path

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from shared.wire.credentials import Credentials

_HOUR = datetime.timedelta(hours=1)
LONGEST = 3650.0
"""A certificate is valid for so long at most [days]."""
_VALID = 2.0 * LONGEST  # [days] of the authority's own certificate
_RENEWED = 1 / 3
"""A certificate is made anew when this share of its time is left."""


@dataclass(frozen=True)
class Wanted:
    """A certificate as it should be.

    Attributes:
        common: common name, by which others know what its owner may do.
        addresses: host names and addresses at which its owner is dialled.
        days: how long it is valid [days].
    """

    common: str
    addresses: tuple[str, ...]
    days: float


class Authority:
    """Signs certificates; made where there is none.

    Args:
        folder: holds its certificate and key; nobody who runs a process needs it.
        anew: make another one: what this one has signed is worth nothing then.
    """

    def __init__(self, folder: Path, anew: bool = False) -> None:
        certificate, key = folder / "authority.pem", folder / "key.pem"
        self.made = anew or not (certificate.exists() and key.exists())
        if self.made:
            folder.mkdir(mode=0o700, exist_ok=True)
            # Without its certificate a key is nobody's: whoever is interrupted here begins anew.
            certificate.unlink(missing_ok=True)
            self._key = ec.generate_private_key(ec.SECP256R1())
            subject = _name("tandem authority")
            builder = _builder(subject, subject, self._key.public_key(), _VALID)
            builder = builder.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            _write(key, _private(self._key), 0o600)
            _write(certificate, _public(builder.sign(self._key, hashes.SHA256())), 0o644)
        else:
            signer = serialization.load_pem_private_key(key.read_bytes(), None)
            assert isinstance(signer, ec.EllipticCurvePrivateKey)
            self._key = signer
        self._certificate = x509.load_pem_x509_certificate(certificate.read_bytes())

    def issue(self, folder: Path, wanted: Wanted) -> None:
        """Put a key, its certificate for both sides of a link, and the authority's certificate into a folder.

        They belong to whoever owns the folder. The certificate comes last: with it the folder is complete.

        Raises:
            ValueError: the certificate would outlive the authority's.
        """
        ends = self._certificate.not_valid_after_utc
        if _in_days(wanted.days) > ends:
            raise ValueError(
                f"--days {wanted.days:g}: the authority ends on {ends:%Y-%m-%d}; make another one with --revoke"
            )
        key = ec.generate_private_key(ec.SECP256R1())
        usage = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH])
        names = [_alternative(address) for address in wanted.addresses]
        builder = (
            _builder(_name(wanted.common), self._certificate.subject, key.public_key(), wanted.days)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(usage, critical=False)
            .add_extension(x509.SubjectAlternativeName(names), critical=False)
        )
        folder.mkdir(mode=0o700, exist_ok=True)
        place = Credentials(folder)
        _write(place.authority, _public(self._certificate), 0o644)
        _write(place.key, _private(key), 0o600)
        _write(place.certificate, _public(builder.sign(self._key, hashes.SHA256())), 0o644)

    def why_anew(self, folder: Path, wanted: Wanted) -> str:
        """Why the certificate in a folder is to be made anew; empty if it will do.

        Raises:
            ValueError: it is somebody else's.
        """
        place = Credentials(folder)
        try:
            held = x509.load_pem_x509_certificate(place.certificate.read_bytes())
            key = serialization.load_pem_private_key(place.key.read_bytes(), None)
            trusted = x509.load_pem_x509_certificate(place.authority.read_bytes())
        except FileNotFoundError:
            return "was missing"
        except ValueError:
            return "was broken"
        common = held.subject.get_attributes_for_oid(NameOID.COMMON_NAME)[0].value
        if common != wanted.common:
            raise ValueError(f"{folder} is {common!s}'s, not {wanted.common}'s: choose another folder, or --renew")
        try:
            held.verify_directly_issued_by(self._certificate)
        except (InvalidSignature, ValueError):
            return "was another authority's"
        if trusted != self._certificate or key.public_key() != held.public_key():
            return "was broken"
        names = held.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
        if lacking := [address for address in wanted.addresses if _alternative(address) not in names]:
            return f"did not name {', '.join(lacking)}"
        ends = held.not_valid_after_utc
        fits = _in_days(_RENEWED * wanted.days) <= ends <= _in_days(wanted.days)
        return "" if fits else f"was to end on {ends:%Y-%m-%d}"


def end_of(folder: Path) -> datetime.datetime:
    """When the certificate in a folder ends."""
    return x509.load_pem_x509_certificate(Credentials(folder).certificate.read_bytes()).not_valid_after_utc


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, days: float
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        # Clocks of two machines may differ.
        .not_valid_before(_in_days(0.0) - _HOUR)
        .not_valid_after(_in_days(days))
    )


def _in_days(days: float) -> datetime.datetime:
    return datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=days)


def _name(common: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common)])


def _alternative(address: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(address))
    except ValueError:
        return x509.DNSName(address)


def _public(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(serialization.Encoding.PEM)


def _private(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )


def _write(path: Path, content: bytes, mode: int) -> None:
    """A file that is there whole or not at all, and belongs to its folder's owner."""
    new = path.with_name(f".{path.name}")
    new.unlink(missing_ok=True)
    with open(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(content)
        owner = path.parent.stat()
        if (owner.st_uid, owner.st_gid) != (os.geteuid(), os.getegid()):
            os.fchown(file.fileno(), owner.st_uid, owner.st_gid)
    new.replace(path)
