"""A lock that gives each robot one driver process: of two servers on a machine, the second waits.

Two processes that send set-points to one robot would each undo the other's stops. The lock is a
name in the abstract namespace of Linux's sockets, which is free again once the process that bound
it has ended, however it ended. Other systems lack such names, so there is no lock.
"""

from __future__ import annotations

import hashlib
import json
import socket
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings


class RobotLock:
    """The lock of the robot in these settings, identified by its driver and the driver's table."""

    def __init__(self, settings: RobotSettings) -> None:
        which = {"driver": settings.driver, "url": settings.serial.url, **settings.own_tables}
        digest = hashlib.sha256(json.dumps(which, sort_keys=True, default=str).encode())
        self._name = f"\0wax-robot-{digest.hexdigest()[:32]}"
        self._socket: socket.socket | None = None

    def acquire(self) -> bool:
        """Try to take the lock until this process ends; return whether it has it; never raises."""
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
        """Release the lock; safe to call twice."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
