"""Self-signed certificates."""

from __future__ import annotations

import datetime
import ipaddress
from typing import TYPE_CHECKING

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from wax.web.certificate import Certificate

if TYPE_CHECKING:
    from pathlib import Path

NOW = datetime.datetime(2030, 6, 1, tzinfo=datetime.UTC)


def write_pair(
    folder: Path,
    *names: str,
    begins: datetime.datetime = NOW - datetime.timedelta(days=30),
    ends: datetime.datetime = NOW + datetime.timedelta(days=60),
) -> Certificate:
    """Write a certificate for these names and addresses, and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "robot")])
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(begins)
        .not_valid_after(ends)
    )
    if names:
        found = x509.SubjectAlternativeName([_general(name) for name in names])
        builder = builder.add_extension(found, critical=False)
    chain_path, key_path = folder / "chain.pem", folder / "key.pem"
    made = builder.sign(key, hashes.SHA256())
    chain_path.write_bytes(made.public_bytes(serialization.Encoding.PEM))
    key_path.write_bytes(
        key.private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            serialization.NoEncryption(),
        )
    )
    return Certificate(chain_path, key_path)


def _general(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
