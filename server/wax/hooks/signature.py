"""The signature of a posted event, by Standard Webhooks 1.0 (standardwebhooks.com)."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
from typing import Final

from wax.errors import StartError
from wax.named_file import told_secret

_PREFIX: Final = "whsec_"
_LEAST_BYTES: Final = 24
_MOST_BYTES: Final = 64
_MAKE: Final = "make one: (umask 077; echo whsec_$(openssl rand -base64 32) > FILE)"


def read_secret(path: str, key: str) -> bytes:
    """Return the secret in a file; raises `StartError`, which names the configuration's `key`."""
    text = told_secret(key, path, f"; {_MAKE}")
    try:
        secret = base64.b64decode(text.decode("ascii").removeprefix(_PREFIX), validate=True)
    except (binascii.Error, UnicodeDecodeError):
        raise StartError(f"{key}: {path} holds no secret in Base64; {_MAKE}") from None
    if not _LEAST_BYTES <= len(secret) <= _MOST_BYTES:
        raise StartError(
            f"{key}: {path} holds a secret of {len(secret)} bytes, and it takes {_LEAST_BYTES} to"
            f" {_MOST_BYTES}; {_MAKE}"
        )
    return secret


def headers(secret: bytes, message_id: str, unix_s: int, body: bytes) -> dict[str, str]:
    """Return the three headers that prove to a receiver who sent this, and when."""
    signed = hmac.digest(secret, f"{message_id}.{unix_s}.".encode() + body, hashlib.sha256)
    return {
        "webhook-id": message_id,
        "webhook-timestamp": str(unix_s),
        "webhook-signature": "v1," + base64.b64encode(signed).decode(),
    }
