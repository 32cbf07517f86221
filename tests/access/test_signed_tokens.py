"""Tokens that a proxy signs: only by its own keys, for us, from its issuer, while they last."""

from __future__ import annotations

import base64
import json
from typing import Any

import jwt
import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from tests.access.signing import CURVE, GOOD, KEYS, NOW_S, OTHER, RSA, jwks, of_rsa, signed

from wax.access.signed_tokens import claims, read_keys
from wax.access.vouching import Vouching
from wax.config.proxy import ProxySettings
from wax.errors import NotAdmittedError


def told(token: str) -> dict[str, Any]:
    keys = read_keys(KEYS)
    return dict(claims(token, keys.get, audience="robot", issuer="https://id.example"))


def part(tree: object) -> str:
    return base64.urlsafe_b64encode(json.dumps(tree).encode()).decode().rstrip("=")


def by_public_key() -> str:
    """Return a token whose secret is the public key, which everybody has (RFC 8725, 2.1)."""
    pem = RSA.public_key().public_bytes(
        serialization.Encoding.PEM, serialization.PublicFormat.SubjectPublicKeyInfo
    )
    body = f"{part({'alg': 'HS256', 'kid': 'rsa'})}.{part(GOOD)}"
    mac = jwt.algorithms.HMACAlgorithm(jwt.algorithms.HMACAlgorithm.SHA256).sign(body.encode(), pem)
    return f"{body}.{base64.urlsafe_b64encode(mac).decode().rstrip('=')}"


def test_a_token_is_believed_by_its_signature() -> None:
    """What is signed by a published key, RSA or elliptic curve, is what it says."""
    assert told(signed())["email"] == "alice@example.org"
    assert told(signed(CURVE, "curve", "ES256"))["groups"] == GOOD["groups"]


@pytest.mark.parametrize(
    "token",
    [
        signed(OTHER),
        signed(CURVE, "rsa", "ES256"),
        signed(RSA, "curve"),
        signed(RSA, by="RS512"),
        signed(RSA, by="PS256"),
        by_public_key(),
        f"{part({'alg': 'none', 'kid': 'rsa'})}.{part(GOOD)}.",
        f"{part({'alg': 'None', 'kid': 'rsa'})}.{part(GOOD)}.",
        f"{signed().rpartition('.')[0]}.",
        f"{part({'alg': 'RS256', 'kid': 'rsa'})}.{part(GOOD)}.{signed().rpartition('.')[2]}",
        signed(aud="another"),
        signed(aud=["another"]),
        signed(aud=None),
        signed(iss="https://mallory.example"),
        signed(iss=None),
        signed(exp=NOW_S - 60),
        signed(exp=None),
        signed(nbf=NOW_S + 600),
        signed(name="x" * 9000),
        "a.b.c",
        "\udcff",
        "alice",
    ],
)
def test_any_other_token_is_not(token: str) -> None:
    """Another's key, another algorithm, none, another audience or issuer, or a past one: nobody."""
    with pytest.raises(ValueError, match=r"."):
        told(token)


@pytest.mark.parametrize("kid", ["new", "", None])
def test_an_unknown_key_is_to_be_looked_for(kid: str | None) -> None:
    """Of a key that is not known yet, the person reads that they are to try again."""
    with pytest.raises(NotAdmittedError, match="try again"):
        told(signed(kid=kid))


WEAK = rsa.generate_private_key(public_exponent=65537, key_size=1024)
SECRET = {"kty": "oct", "k": "c2VjcmV0", "kid": "secret"}
PRIVATE = {**json.loads(jwt.algorithms.RSAAlgorithm.to_jwk(RSA)), "kid": "private"}
OTHER_CURVE = json.loads(jwt.algorithms.ECAlgorithm.to_jwk(ec.generate_private_key(ec.SECP384R1())))


@pytest.mark.parametrize(
    "text",
    [
        jwks(),
        jwks(SECRET, PRIVATE, of_rsa(WEAK, "weak"), OTHER_CURVE | {"kid": "other"}),
        jwks(of_rsa(RSA, "for secrets", use="enc"), of_rsa(RSA, "other", alg="RS512")),
        jwks({"kty": "RSA", "kid": "half"}, {"kid": "nothing"}, {"kty": "RSA"}),
        b"[]",
        b'{"keys": 7}',
        b'{"keys": [1, [], "x"]}',
    ],
)
def test_only_good_public_keys_are_taken(text: bytes) -> None:
    """Secrets, private halves, short keys, and keys for something else count as none."""
    with pytest.raises(ValueError, match="no public key"):
        read_keys(text)


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        ({}, None),
        ({"groups": "staff, pupils"}, None),
        ({"groups": None}, "door.not_for_group"),
        ({"groups": [["pupils"], 7]}, "door.not_for_group"),
        ({"email": None}, "door.not_signed_in"),
        ({"email": ["alice@example.org"]}, "door.unclear_sign_in"),
        ({"email": 7}, "door.unclear_sign_in"),
        ({"aud": "another"}, "door.unclear_sign_in"),
    ],
)
def test_its_claims_are_the_person(changed: dict[str, Any], code: str | None) -> None:
    """Person, name and groups are claims of the token; a header of the same name is nothing."""
    settings = ProxySettings(
        person="email",
        name="name",
        groups="groups",
        drive=["pupils"],
        token="Cf-Access-Jwt-Assertion",
        keys="keys.json",
        issuer="https://id.example",
        audience="robot",
    )
    vouching = Vouching(settings, told)
    assert vouching.names == {"cf-access-jwt-assertion"}
    said = {"cf-access-jwt-assertion": [signed(**changed)], "email": ["mallory"]}
    vouched = vouching.judge(said, 0.0)
    assert (vouched.refusal and vouched.refusal.code) == code
    assert vouched.right == ("drive" if code is None else "stranger")
    assert vouched.name == ("Alice" if vouched.identity else "")
    doubled = {"cf-access-jwt-assertion": [signed(), signed()]}
    assert vouching.judge(doubled, 0.0).refusal is not None
