"""A browser's certificate must be self-signed; chains are refused."""

from __future__ import annotations

import weakref
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any, Final

import pytest
from aiortc import RTCCertificate, RTCPeerConnection
from aiortc.rtcdtlstransport import SRTP_PROFILES
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.x509.oid import NameOID
from OpenSSL import SSL, crypto

from wax.rtc import datagram, private

if TYPE_CHECKING:
    from collections.abc import Sequence

Key = ec.EllipticCurvePrivateKey | rsa.RSAPrivateKey

_NOW: Final = datetime.now(UTC)


def signed(name: str, key: Key, issuer: str, issuer_key: Key) -> x509.Certificate:
    return (
        x509.CertificateBuilder()
        .subject_name(x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)]))
        .issuer_name(x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, issuer)]))
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(_NOW - timedelta(days=1))
        .not_valid_after(_NOW + timedelta(days=1))
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(issuer_key, hashes.SHA256())
    )


def shakes_hands(
    key: Key, chain: Sequence[x509.Certificate], own: RTCCertificate | None = None
) -> bool:
    """Return whether a handshake with our server completes, or raise what the server says."""
    private.install()
    own = own or RTCCertificate.generateCertificate()
    server = SSL.Connection(own._create_ssl_context(SRTP_PROFILES))
    server.set_accept_state()
    context = SSL.Context(SSL.DTLS_METHOD)
    context.use_certificate(chain[0])
    context.use_privatekey(key)
    for issuer in chain[1:]:
        context.add_extra_chain_cert(issuer)
    context.set_tlsext_use_srtp(SRTP_PROFILES[0].openssl_profile)
    client = SSL.Connection(context)
    client.set_connect_state()
    is_done = False
    for _ in range(10):
        for one, other in ((client, server), (server, client)):
            try:
                one.do_handshake()
                is_done = one is server
            except SSL.WantReadError:
                pass
            while sent := _sent(one):
                other.bio_write(sent)
    return is_done


def _sent(one: SSL.Connection) -> bytes:
    try:
        return one.bio_read(datagram.MAX_BYTES)
    except SSL.WantReadError:
        return b""


def test_a_self_signed_certificate_is_accepted() -> None:
    """A self-signed certificate of the usual curve completes the handshake."""
    key = ec.generate_private_key(ec.SECP256R1())
    assert shakes_hands(key, [signed("me", key, "me", key)])


def test_what_verifies_a_certificate_is_freed_at_once() -> None:
    """It is freed without the garbage collector, whose full run comes twice an hour."""
    private.install()
    context: Any = RTCCertificate.generateCertificate()._create_ssl_context(SRTP_PROFILES)
    verifies = weakref.ref(context._verify_helper)
    del context
    assert verifies() is None


def test_a_certificate_chain_is_refused() -> None:
    """A certificate signed by another is refused before any signature is verified."""
    key, other = (ec.generate_private_key(ec.SECP256R1()) for _ in range(2))
    chain = [signed("me", key, "other", other), signed("other", other, "third", other)]
    with pytest.raises(SSL.Error, match="certificate verify failed"):
        shakes_hands(key, chain)


async def test_a_configured_server_may_show_a_chain() -> None:
    """The media server to which pictures are published may show a certificate of an authority."""
    pc = RTCPeerConnection()
    private.mark_other_end_known(pc)
    key, other = (ec.generate_private_key(ec.SECP256R1()) for _ in range(2))
    chain = [signed("me", key, "other", other), signed("other", other, "third", other)]
    assert shakes_hands(key, chain, getattr(pc, private._CERTIFICATES)[0])
    await pc.close()


@pytest.mark.parametrize(
    ("exponent", "bits", "is_taken"),
    [(65537, 2048, True), (2**32 + 1, 2048, False), (65537, 4104, False)],
)
def test_an_expensive_key_is_refused(exponent: int, bits: int, is_taken: bool) -> None:
    """An RSA key is accepted only with a size and an exponent like browsers' own."""
    made = rsa.RSAPublicNumbers(exponent, 2**bits - 1).public_key()
    key = ec.generate_private_key(ec.SECP256R1())
    certificate = (
        x509.CertificateBuilder()
        .subject_name(x509.Name([]))
        .issuer_name(x509.Name([]))
        .public_key(made)
        .serial_number(1)
        .not_valid_before(_NOW)
        .not_valid_after(_NOW + timedelta(days=1))
        .sign(key, hashes.SHA256())
    )
    shown = crypto.X509.from_cryptography(certificate)
    connection = SSL.Connection(SSL.Context(SSL.DTLS_METHOD))
    assert private._is_cheap_leaf(connection, shown, 18, 0, 0) is is_taken
    assert not private._is_cheap_leaf(connection, shown, 18, 1, 0)


def record(*messages: bytes) -> bytes:
    body = b"".join(messages)
    return b"\x16\xfe\xfd" + bytes(8) + len(body).to_bytes(2) + body


def message(kind: int, length: int, fragment: bytes) -> bytes:
    return bytes([kind]) + length.to_bytes(3) + bytes(5) + len(fragment).to_bytes(3) + fragment


@pytest.mark.parametrize(
    ("data", "is_long"),
    [
        (record(message(11, datagram.MAX_CERTIFICATE_BYTES, b"a" * 1000)), False),
        (record(message(11, datagram.MAX_CERTIFICATE_BYTES + 1, b"a" * 1000)), True),
        (record(message(16, 66, b"k" * 66), message(11, 100_000, b"a")), True),
        (record(message(1, 100, b"h" * 100)) + record(message(11, 100_000, b"a")), True),
        (record(message(16, 100_000, b"k")), False),
        (record(b"\x0b\xff"), False),
    ],
)
def test_a_long_certificate_does_not_reach_openssl(data: bytes, is_long: bool) -> None:
    """A long certificate is detected by any of its fragments, anywhere in a datagram."""
    assert datagram.is_plausible(data)
    assert datagram.has_long_certificate(data) is is_long
