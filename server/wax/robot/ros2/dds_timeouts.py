"""The command timeouts that the subscribers' nodes have as parameters."""

from __future__ import annotations

import math
import struct
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from wax.robot.ros2.dds_parameters import ParameterClient

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cyclonedds.domain import DomainParticipant

NAMES: Final = ("cmd_vel_timeout", "velocity_timeout", "reference_timeout")
"""As in diff_drive_controller, nav2's velocity_smoother, the steering and mecanum controllers."""
ANSWER_S: Final = 1.5
AGAIN_S: Final = 30.0
"""The polling interval: a parameter can be changed while the robot runs."""
MAX_NODES: Final = 16


class ReceiverTimeouts:
    """Asks one node after the other for one name after the other, one step per `poll`."""

    def __init__(self, member: DomainParticipant) -> None:
        self._member = member
        self._found: dict[str, float | None] = {}
        self._asked_s: dict[str, float] = {}
        self._node = ""
        self._client: ParameterClient | None = None
        self._names: list[str] = []
        self._until_s = math.inf
        self._is_asked = False

    def poll(self, nodes: Mapping[str, str], now_s: float) -> float | None:
        """Return the longest timeout of these nodes, 0 if one never stops, None if none is known.

        `nodes` has the identifier of each node's service.
        """
        with suppress(ValueError, AssertionError, IndexError, struct.error):  # an invalid answer
            self._step(dict(list(nodes.items())[:MAX_NODES]), now_s)
        known = [value for node in nodes if (value := self._found.get(node)) is not None]
        if not known:
            return None
        return 0.0 if min(known) <= 0.0 else max(known)

    def _step(self, nodes: Mapping[str, str], now_s: float) -> None:
        if self._client is None:
            self._begin(nodes, now_s)
            return
        if not self._is_asked and self._client.is_ready:
            self._client.ask(self._names[0])
            self._is_asked, self._until_s = True, now_s + ANSWER_S
        is_here, value = self._client.answer() if self._is_asked else (False, None)
        if value is not None and math.isfinite(value):
            self._found[self._node] = value
            self._client = None
        elif is_here:
            self._next_name(now_s)
        elif now_s >= self._until_s:
            self._client = None  # it does not answer, so its earlier answer may be outdated
            self._found.pop(self._node, None)

    def _begin(self, nodes: Mapping[str, str], now_s: float) -> None:
        for node, server in nodes.items():
            if now_s - self._asked_s.get(node, -math.inf) >= AGAIN_S:
                self._asked_s[node] = now_s
                self._node, self._names = node, list(NAMES)
                self._client = ParameterClient(self._member, node, server)
                self._is_asked, self._until_s = False, now_s + ANSWER_S
                return

    def _next_name(self, now_s: float) -> None:
        self._is_asked, self._until_s = False, now_s + ANSWER_S
        self._names.pop(0)
        if not self._names:
            self._client = None
            self._found[self._node] = None
