"""The signature of a posted event, as Standard Webhooks 1.0 has it (standardwebhooks.com)."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
from typing import Final

from wax.errors import StartError, reason_of
from wax.named_file import read_secret as read_file

_PREFIX: Final = "whsec_"
_LEAST_BYTES: Final = 24
_MOST_BYTES: Final = 64
_MAKE: Final = "make one: (umask 077; echo whsec_$(openssl rand -base64 32) > FILE)"


def read_secret(path: str, key: str) -> bytes:
    """Return the secret in a file; raises `StartError`, which names the configuration's `key`."""
    try:
        text = read_file(path).decode("ascii").strip()
        secret = base64.b64decode(text.removeprefix(_PREFIX), validate=True)
    except OSError as error:
        raise StartError(f"{key}: {path} cannot be read: {reason_of(error)}") from error
    except (binascii.Error, UnicodeDecodeError):
        raise StartError(f"{key}: {path} holds no secret in Base64; {_MAKE}") from None
    if not text:
        raise StartError(f"{key}: {path} is empty; {_MAKE}")
    if not _LEAST_BYTES <= len(secret) <= _MOST_BYTES:
        raise StartError(
            f"{key}: {path} holds a secret of {len(secret)} bytes, and it takes {_LEAST_BYTES} to"
            f" {_MOST_BYTES}; {_MAKE}"
        )
    return secret


def headers(secret: bytes, message_id: str, unix_s: int, body: bytes) -> dict[str, str]:
    """Return the three headers by which a receiver knows who sent this, and when."""
    signed = hmac.digest(secret, f"{message_id}.{unix_s}.".encode() + body, hashlib.sha256)
    return {
        "webhook-id": message_id,
        "webhook-timestamp": str(unix_s),
        "webhook-signature": "v1," + base64.b64encode(signed).decode(),
    }
