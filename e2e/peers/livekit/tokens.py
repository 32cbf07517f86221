"""The tokens that LiveKit wants: who someone is and what they may do, signed with a shared key."""

from __future__ import annotations

import os
import secrets
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Final, Self

import jwt

ROOM: Final = "lab"
_VALID: Final = timedelta(hours=6)


@dataclass(frozen=True, slots=True)
class Key:
    """What the server and whoever signs tokens share; LiveKit wants 32 characters of secret."""

    name: str
    secret: str

    @classmethod
    def make(cls) -> Self:
        """Make one, or take what ``LIVEKIT_API_KEY`` and ``LIVEKIT_API_SECRET`` have."""
        name, secret = os.environ.get("LIVEKIT_API_KEY"), os.environ.get("LIVEKIT_API_SECRET")
        if name and secret:
            return cls(name, secret)
        return cls(f"API{secrets.token_hex(6)}", secrets.token_urlsafe(32))


def publisher_token(key: Key, identity: str) -> str:
    """May publish in the room, and nothing else."""
    return _sign(key, identity, can_publish=True)


def viewer_token(key: Key, identity: str) -> str:
    """May subscribe in the room; two who have the same identity put each other out."""
    return _sign(key, identity, can_publish=False)


def _sign(key: Key, identity: str, *, can_publish: bool) -> str:
    now = datetime.now(UTC)
    grants = {
        "room": ROOM,
        "roomJoin": True,
        "canPublish": can_publish,
        "canSubscribe": not can_publish,
        "canPublishData": False,
    }
    claims = {
        "iss": key.name,
        "sub": identity,
        "nbf": now - timedelta(minutes=1),
        "exp": now + _VALID,
        "video": grants,
    }
    return jwt.encode(claims, key.secret, algorithm="HS256")
