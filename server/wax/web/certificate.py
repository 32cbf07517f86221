"""A certificate's files: the host's, or the self-signed one of ``--https``, made once and kept.

Its fingerprint is printed, so that people can compare it with what the browser shows. `tls` loads
renewed files without a restart.
"""

from __future__ import annotations

import datetime
import ipaddress
import ssl
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from wax import state_dir
from wax.errors import StartError, reason_of
from wax.named_file import read_bytes

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

LASTS: Final = datetime.timedelta(days=820)
"""Safari accepts no certificate that is valid for more than 825 days."""
RENEW_BEFORE: Final = datetime.timedelta(days=30)


@dataclass(frozen=True, slots=True)
class Certificate:
    """The files of a certificate and of its key."""

    chain: Path
    key: Path

    def fingerprint(self) -> str:
        """Return the SHA-256 fingerprint of the first certificate, as browsers write it.

        Raises `StartError`.
        """
        digest = _read(self.chain).fingerprint(hashes.SHA256())
        return digest.hex(":").upper()

    def names(self) -> set[str]:
        """Return the names and addresses that it is valid for; raises `StartError`."""
        try:
            found = _read(self.chain).extensions.get_extension_for_class(
                x509.SubjectAlternativeName
            )
        except x509.ExtensionNotFound:
            return set()
        return {str(name.value) for name in found.value}

    def validity(self) -> tuple[datetime.datetime, datetime.datetime]:
        """Return when it becomes valid and expires; raises `StartError`."""
        first = _read(self.chain)
        return first.not_valid_before_utc, first.not_valid_after_utc

    def context(self) -> ssl.SSLContext:
        """Return the server's TLS context; raises `StartError`."""
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        _offer_one_key_exchange(context)
        try:
            for path in (self.chain, self.key):
                read_bytes(path)  # OpenSSL would wait for a pipe, and read a device without end
            context.load_cert_chain(self.chain, self.key, password=self._ask_nobody)
        except OSError as error:  # or SSLError
            raise StartError(
                f"the certificate {self.chain} with the key {self.key} cannot be used:"
                f" {reason_of(error)}; check [server] certificate and key"
            ) from error
        return context

    def _ask_nobody(self) -> str:
        """Refuse an encrypted key: OpenSSL would ask at the terminal for its password."""
        raise StartError(
            f"the key {self.key} is encrypted; save it without a password, for example by:"
            f" openssl pkey -in {self.key} -out FILE"
        )


def _offer_one_key_exchange(context: ssl.SSLContext) -> None:
    """Leave the client no choice: up to ffdhe8192 it would cost us many milliseconds in one step.

    That is CVE-2022-40735. Browsers have both groups, and send the key of the first at once.
    """
    try:
        context.set_ecdh_curve("X25519")
    except (ValueError, ssl.SSLError):  # OpenSSL 1.1, and Python 3.11.2 of Debian 12
        context.set_ecdh_curve("prime256v1")


def kept_in(folder: Path) -> Certificate:
    """Return the paths of our own certificate, whether or not it exists yet."""
    return Certificate(folder / "certificate.pem", folder / "key.pem")


def self_signed(folder: Path, names: Iterable[str], now: datetime.datetime) -> Certificate:
    """Return the certificate kept in `folder`, or make one for these names and addresses.

    It is reused as long as possible, since people must accept each new one: until a month before
    it expires, or until one of the names is missing in it. Raises `StartError` if the folder
    cannot be used.
    """
    kept = kept_in(folder)
    names = set(names)
    try:
        if _lasts(kept, now) and names <= kept.names():
            return kept
        key = ec.generate_private_key(ec.SECP256R1())
        _write(kept.key, _key_bytes(key), 0o600)
        _write(kept.chain, _certificate_bytes(key, names, now), 0o644)
    except OSError as error:
        raise StartError(
            f"cannot keep a certificate in {folder}: {reason_of(error)}; make it writable"
        ) from error
    return kept


def _lasts(kept: Certificate, now: datetime.datetime) -> bool:
    """Whether certificate and key exist, match, and are valid for another month."""
    try:
        begins, ends = kept.validity()
        kept.context()
    except StartError:
        return False
    # One from the future was made while the clock was wrong: browsers would refuse it for years.
    return begins <= now < ends - RENEW_BEFORE


def _read(path: Path) -> x509.Certificate:
    try:
        return x509.load_pem_x509_certificate(read_bytes(path))
    except (OSError, ValueError) as error:
        why = reason_of(error)
        raise StartError(f"the certificate {path} cannot be read: {why}") from error


def _key_bytes(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )


def _certificate_bytes(
    key: ec.EllipticCurvePrivateKey, names: Iterable[str], now: datetime.datetime
) -> bytes:
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "WAX")])
    server_auth = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH])
    certificate = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + LASTS)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(server_auth, critical=False)
        .add_extension(
            x509.SubjectAlternativeName([_general_name(name) for name in sorted(names)]),
            critical=False,
        )
        .sign(key, hashes.SHA256())
    )
    return certificate.public_bytes(serialization.Encoding.PEM)


def _general_name(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)


def _write(path: Path, data: bytes, mode: int) -> None:
    """Replace a file atomically; at no time can anybody else read the key."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    state_dir.replace(path, data, mode)
