"""Checks the tokens that a proxy signs (JWT, RFC 7519), by its public keys (JWKS, RFC 7517). Pure.

The algorithm is the key's own, never the token's choice (RFC 8725, 3.1).
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final

import jwt
from cryptography.hazmat.primitives.asymmetric.rsa import RSAPublicKey

from wax.errors import NotAdmittedError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

Keys = dict[str, jwt.PyJWK]
"""Public keys by their names (``kid``)."""

ALGORITHMS: Final = ("RS256", "ES256")
MOST_BYTES: Final = 65_536
_MOST_CHARS: Final = 8192
_LEAST_BITS: Final = 2048
_CLOCKS_APART_S: Final = 10
_NO_KEYS: Final = Sentence("door.no_keys")


def read_keys(text: bytes) -> Keys:
    """Return the keys that may sign; raises `ValueError` if there is none."""
    tree = json.loads(text)
    listed = tree.get("keys") if isinstance(tree, dict) else None
    keys = {}
    for one in listed if isinstance(listed, list) else []:
        name = one.get("kid") if isinstance(one, dict) else None
        if not isinstance(name, str) or one.get("use", "sig") != "sig" or "d" in one:
            continue
        try:
            key = jwt.PyJWK.from_dict(one)
        except (jwt.PyJWTError, ValueError, TypeError, KeyError):
            continue
        if key.algorithm_name in ALGORITHMS and _is_strong(key.key):
            keys[name] = key
    if not keys:
        raise ValueError(f"it has no public key with a name (kid) for {' or '.join(ALGORITHMS)}")
    return keys


def _is_strong(key: object) -> bool:
    return not isinstance(key, RSAPublicKey) or key.key_size >= _LEAST_BITS


def claims(
    token: str, key_of: Callable[[str], jwt.PyJWK | None], *, audience: str, issuer: str
) -> Mapping[str, Any]:
    """Return what a valid token says; raises `ValueError` for any other.

    `key_of` returns a key by its name. Raises `NotAdmittedError` if it has none of that name.
    """
    if len(token) > _MOST_CHARS:
        raise ValueError("a token of more characters than any has")
    try:
        name = jwt.get_unverified_header(token).get("kid")
        key = key_of(name) if isinstance(name, str) else None
        if key is None:
            raise NotAdmittedError(_NO_KEYS)
        return jwt.decode(
            token,
            key,
            algorithms=[key.algorithm_name],
            audience=audience,
            issuer=issuer,
            leeway=_CLOCKS_APART_S,
            options={"require": ["exp", "aud", "iss"]},
        )
    except jwt.PyJWTError as error:
        raise ValueError(str(error)) from error
