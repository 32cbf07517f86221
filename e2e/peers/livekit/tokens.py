"""The tokens that LiveKit wants: who someone is and what they may do, signed with a shared key."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, Final, Self

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
        return cls(f"API{secrets.token_hex(6)}", secrets.token_urlsafe(32))


def signed(key: Key, identity: str, **grants: Any) -> str:
    """Sign a token with these grants, LiveKit's ``video``."""
    now = datetime.now(UTC)
    claims = {
        "iss": key.name,
        "sub": identity,
        "nbf": now - timedelta(minutes=1),
        "exp": now + _VALID,
        "video": grants,
    }
    return jwt.encode(claims, key.secret, algorithm="HS256")


def in_room(key: Key, identity: str, *, publishes: bool) -> str:
    """Sign that one may publish in the room, or subscribe, and nothing else.

    Two who have the same identity put each other out.
    """
    may = {"canPublish": publishes, "canSubscribe": not publishes, "canPublishData": False}
    return signed(key, identity, room=ROOM, roomJoin=True, **may)
