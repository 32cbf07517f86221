"""Attacks by DTLS: certificates with chains whose signatures are dear to verify."""

from __future__ import annotations

import asyncio
import random
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from functools import cache
from itertools import cycle
from math import gcd, lcm
from typing import TYPE_CHECKING, Any, Final

from aiortc import RTCCertificate
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.x509.oid import NameOID

from e2e.strangers.ground import address
from e2e.strangers.intruder import Intruder

if TYPE_CHECKING:
    from OpenSSL import SSL

    from e2e.strangers.ground import Ground

    Key = ec.EllipticCurvePrivateKey | rsa.RSAPrivateKey

_TRIED_S: Final = 2.0
_RSA: Final = 40
_BRAINPOOL: Final = 80
"""Certificates in a chain: as many as OpenSSL takes in 100 KB."""


class _Chain(RTCCertificate):
    """A certificate that is shown with all its issuers."""

    def __init__(self, issuer_key: Key, length: int) -> None:
        key = ec.generate_private_key(ec.SECP256R1())
        super().__init__(key, _signed(0, key, issuer_key))
        self._issuers = [_signed(number, issuer_key, issuer_key) for number in range(1, length)]

    def _create_ssl_context(self, srtp_profiles: list[Any]) -> SSL.Context:
        context = super()._create_ssl_context(srtp_profiles)
        for issuer in self._issuers:
            context.add_extra_chain_cert(issuer)
        return context


async def chains(ground: Ground, rate_hz: float, sources: int) -> None:
    """Connect again and again, and show a chain each time."""
    trying: set[asyncio.Task[None]] = set()

    async def one(source: str, certificate: _Chain) -> None:
        intruder = Intruder(ground.port, source=source)
        intruder.show(certificate)
        try:
            with suppress(ConnectionError, TimeoutError):
                async with asyncio.timeout(_TRIED_S):
                    await intruder.connect()
                ground.account["connected"] += 1
        finally:
            await intruder.close()

    turns = zip(cycle(map(address, range(sources))), cycle(made()), strict=False)
    try:
        async for _ in ground.ticks(1 / rate_hz):
            task = asyncio.create_task(one(*next(turns)))
            trying.add(task)
            task.add_done_callback(trying.discard)
            ground.account["handshakes"] += 1
    finally:
        for task in trying:
            task.cancel()
        await asyncio.gather(*trying, return_exceptions=True)


@cache
def made() -> tuple[_Chain, _Chain]:
    """Return both chains; making them takes a second."""
    brainpool = ec.generate_private_key(ec.BrainpoolP512R1())
    return _Chain(_rsa_with_long_exponent(), _RSA), _Chain(brainpool, _BRAINPOOL)


def _rsa_with_long_exponent() -> rsa.RSAPrivateKey:
    """Return a key of 3,072 bits with an exponent of 3,070, so that verifying takes longest."""
    numbers = rsa.generate_private_key(65_537, 3072).private_numbers()
    p, q = numbers.p, numbers.q
    order = lcm(p - 1, q - 1)
    e = random.getrandbits(3070) | 1 << 3069 | 1
    while gcd(e, order) != 1:
        e += 2
    d = pow(e, -1, order)
    public = rsa.RSAPublicNumbers(e, p * q)
    own = rsa.RSAPrivateNumbers(p, q, d, d % (p - 1), d % (q - 1), numbers.iqmp, public)
    return own.private_key(unsafe_skip_rsa_key_validation=True)


def _signed(number: int, key: Key, issuer_key: Key) -> x509.Certificate:
    def name(number: int) -> x509.Name:
        return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, str(number))])

    now = datetime.now(UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(name(number))
        .issuer_name(name(number + 1))
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + timedelta(days=1))
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(issuer_key, hashes.SHA512())
    )
