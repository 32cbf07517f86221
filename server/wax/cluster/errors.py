"""What goes wrong with a room; nobody who drives notices."""

from __future__ import annotations

from wax.errors import WaxError


class RoomError(WaxError):
    """A room that cannot be used now, in a sentence; it is tried again."""
