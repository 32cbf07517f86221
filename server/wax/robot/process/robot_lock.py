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


class RobotLock:
    """The lock of these settings' robot: of its driver, with that driver's own table."""

    def __init__(self, settings: RobotSettings) -> None:
        which = {"driver": settings.driver, "url": settings.serial.url, **settings.own_tables}
        digest = hashlib.sha256(json.dumps(which, sort_keys=True, default=str).encode())
        self._name = f"\0wax-robot-{digest.hexdigest()[:32]}"
        self._socket: socket.socket | None = None

    def acquire(self) -> bool:
        """Whether this process has it, from now on until it ends; never raises."""
        if self._socket is not None or sys.platform != "linux":
            return True
        held = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            held.bind(self._name)
        except OSError:
            held.close()
            return False
        self._socket = held
        return True

    def release(self) -> None:
        """Let another have it; safe to call twice."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
