"""One robot, one driver process: of two servers on a machine, the second waits.

Two that send set-points to one robot would each undo what the other stops. A name in the abstract
namespace of Linux's sockets belongs to whoever has bound it, and to nobody once that process has
ended, however it did. Elsewhere there is no such name, and only what a driver opens can tell.
"""

from __future__ import annotations

import hashlib
import json
import socket
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.config.settings import RobotSettings


class RobotPlace:
    """The place at the robot of these settings: its driver, with that driver's own table."""

    def __init__(self, settings: RobotSettings) -> None:
        which = {"driver": settings.driver, "url": settings.serial.url, **settings.own_tables}
        digest = hashlib.sha256(json.dumps(which, sort_keys=True, default=str).encode())
        self._name = f"\0wax-robot-{digest.hexdigest()[:32]}"
        self._socket: socket.socket | None = None

    def take(self) -> bool:
        """Whether the place is this process's, from now on until it ends; never raises."""
        if self._socket is not None or sys.platform != "linux":
            return True
        place = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            place.bind(self._name)
        except OSError:
            place.close()
            return False
        self._socket = place
        return True

    def leave(self) -> None:
        """Give the place up; safe to call twice."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
