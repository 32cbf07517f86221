"""Keys that sign, as a proxy publishes them."""

from __future__ import annotations

import json
from typing import Any, Final

import jwt
from cryptography.hazmat.primitives.asymmetric import ec, rsa

from wax.clock import SystemClock

NOW_S: Final = SystemClock().wall_ms() / 1000
"""PyJWT compares with the machine's own clock."""
GOOD: Final[dict[str, Any]] = {
    "email": "alice@example.org",
    "name": "Alice",
    "groups": ["pupils", "cn=a,ou=b"],
    "aud": ["robot"],
    "iss": "https://id.example",
    "exp": NOW_S + 600,
}
RSA: Final = rsa.generate_private_key(public_exponent=65537, key_size=2048)
OTHER: Final = rsa.generate_private_key(public_exponent=65537, key_size=2048)
CURVE: Final = ec.generate_private_key(ec.SECP256R1())


def of_rsa(key: rsa.RSAPrivateKey, kid: str, **more: Any) -> dict[str, Any]:
    """Return the public half of a key, as in a JWKS."""
    made = json.loads(jwt.algorithms.RSAAlgorithm.to_jwk(key.public_key()))
    return {**made, "kid": kid, **more}


def of_curve(key: ec.EllipticCurvePrivateKey, kid: str) -> dict[str, Any]:
    return {**json.loads(jwt.algorithms.ECAlgorithm.to_jwk(key.public_key())), "kid": kid}


def jwks(*keys: dict[str, Any]) -> bytes:
    return json.dumps({"keys": [*keys]}).encode()


KEYS: Final = jwks(of_rsa(RSA, "rsa", use="sig"), of_curve(CURVE, "curve"))


def signed(key: Any = RSA, kid: str | None = "rsa", by: str = "RS256", **changed: Any) -> str:
    """Return a token of `GOOD` with some claims changed; None leaves one out."""
    told = {name: value for name, value in (GOOD | changed).items() if value is not None}
    return jwt.encode(told, key, algorithm=by, headers={} if kid is None else {"kid": kid})
