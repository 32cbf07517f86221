"""Failures of a room, which never affect driving."""

from __future__ import annotations

from wax.errors import WaxError
from wax.second_look import explained_aside
from wax.unreachable import Target


class RoomError(WaxError):
    """Why a room cannot be used now, in a sentence; it is retried."""


async def not_reached(url: str, error: Exception, limit_s: float) -> RoomError:
    """Return why the server at an address does not answer."""
    target = Target.of(url, limit_s)
    assert target is not None, "the configuration takes no other address"
    return RoomError(f"{url} does not answer. {await explained_aside(target, error)}")
