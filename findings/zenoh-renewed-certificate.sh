#!/usr/bin/env bash
# Zenoh 1.10.2 (Python): the files of a certificate are read anew at each dial, and never again by who listens.
#
# Expected: one rule for both ends of TLS. Either a renewed certificate is taken over by the next connection, or a
# session keeps what it was opened with.
# Found: both, by role. After the files of router and client were replaced, a connection that the router accepts shows
# the certificate of before, and the client that lost its connection comes back with the new one. A listener's
# certificate so ends however often its files were renewed, unless its session is closed and opened again.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --disable-pip-version-check -q eclipse-zenoh==1.10.2 cryptography==46.0.3
cat > "$work/try.py" <<'PY'
import datetime
import ipaddress
import json
import socket
import ssl
import sys
import threading
import time
from pathlib import Path

import zenoh
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

folder, PORT, THROUGH = Path(sys.argv[1]), 17983, 17984
TLS = "transport/link/tls"


def write(path, name, issuer=None, authority_key=None):
    """A certificate of a name, signed by an issuer or by itself; its serial number tells it from the one before."""
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    now = datetime.datetime.now(datetime.timezone.utc)
    made = (
        x509.CertificateBuilder()
        .subject_name(subject).issuer_name(issuer or subject).public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1)).not_valid_after(now + datetime.timedelta(days=1))
        .add_extension(x509.BasicConstraints(ca=issuer is None, path_length=None), critical=True)
        .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]), False)
        .sign(authority_key or key, hashes.SHA256())
    )
    path.with_suffix(".pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    path.with_suffix(".key").write_bytes(key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()))
    return made, key


authority, authority_key = write(folder / "authority", "authority")


def renew(name):
    return write(folder / name, name, authority.subject, authority_key)[0].serial_number


def settings(mode, **more):
    config = zenoh.Config()
    for key, value in {"mode": mode, "scouting/multicast/enabled": False,
                       f"{TLS}/root_ca_certificate": str(folder / "authority.pem"), **more}.items():
        config.insert_json5(key, json.dumps(value))
    return config


def shown():
    """Serial number of the certificate that is shown to a new connection at the router's port."""
    text = ssl.get_server_certificate(("127.0.0.1", PORT))
    return x509.load_pem_x509_certificate(text.encode()).serial_number


dialled = []


def stand_in():
    """A listener with Python's own TLS: takes note of who dials it, and ends the connection."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "router.pem", folder / "router.key")
    context.load_verify_locations(folder / "authority.pem")
    context.verify_mode = ssl.CERT_REQUIRED
    listener = socket.create_server(("127.0.0.1", THROUGH))
    while True:
        connection, _ = listener.accept()
        try:
            with context.wrap_socket(connection, server_side=True) as secured:
                secured.recv(1)
                dialled.append(x509.load_der_x509_certificate(secured.getpeercert(True)).serial_number)
        except OSError:
            pass


before = {name: renew(name) for name in ("router", "client")}
threading.Thread(target=stand_in, daemon=True).start()
router = zenoh.open(settings("router", **{
    "listen/endpoints": [f"tls/127.0.0.1:{PORT}"],
    f"{TLS}/listen_certificate": str(folder / "router.pem"), f"{TLS}/listen_private_key": str(folder / "router.key")}))
client = zenoh.open(settings("peer", **{
    "connect/endpoints": [f"tls/127.0.0.1:{THROUGH}"], "connect/timeout_ms": -1, "connect/exit_on_failure": False,
    "listen/endpoints": [], f"{TLS}/enable_mtls": True,
    f"{TLS}/connect_certificate": str(folder / "client.pem"), f"{TLS}/connect_private_key": str(folder / "client.key")}))


def wait_for(what):
    deadline = time.monotonic() + 20.0
    while not what():
        assert time.monotonic() < deadline, "nothing happens"
        time.sleep(0.05)


wait_for(lambda: before["client"] in dialled)
assert shown() == before["router"]
after = {name: renew(name) for name in ("router", "client")}
wait_for(lambda: after["client"] in dialled)
time.sleep(3.0)
print("who dials shows the", "new" if dialled[-1] == after["client"] else "old", "certificate;",
      "who listens the", "new" if shown() == after["router"] else "old", "one")
assert dialled[-1] == after["client"] and shown() == before["router"], "Zenoh reads its files otherwise now"
client.close()
router.close()
PY
"$work/venv/bin/python" "$work/try.py" "$work"
