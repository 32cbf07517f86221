"""LiveKit's tokens: who somebody is and what they may do, signed with a shared key."""

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
    """The key that the server and the signers share; LiveKit needs a secret of 32 characters."""

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
    """Return a token that allows publishing in the room, or subscribing, and nothing else.

    Two people with the same identity disconnect each other.
    """
    may = {"canPublish": publishes, "canSubscribe": not publishes, "canPublishData": False}
    return signed(key, identity, room=ROOM, roomJoin=True, **may)
