"""The publishers and subscribers of the command topic, as reported by rosapi (pure)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from wax.robot.ros2.command_topic import Endpoint, Traffic
from wax.robot.ros2.rosbridge_protocol import CALLS, call

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.robot.ros2.rosbridge_protocol import ServiceAnswer

ASK_S: Final = 1.0
OLD_S: Final = 3.5
"""An answer older than this is expired."""
_QUESTIONS: Final = ("subscribers", "publishers", "topic_type")


class RosbridgeGraph:
    """Polls rosapi once a second. Without rosapi nothing is known, which does not stop driving.

    rosapi names nodes. All clients of one rosbridge server publish under that server's name, so
    other publishers on the same server cannot be told from us.
    """

    def __init__(self, topic: str, node: str) -> None:
        self._topic = topic
        self._node = node
        self._asked_s = -math.inf
        self._answers: dict[str, tuple[Any, float]] = {}

    def questions(self, now_s: float) -> Iterator[str]:
        """Return the requests to send now."""
        if now_s - self._asked_s >= ASK_S:
            self._asked_s = now_s
            for name in _QUESTIONS:
                yield call(f"{CALLS}{name}", f"/rosapi/{name}", topic=self._topic)

    def handle_answer(self, answer: ServiceAnswer, now_s: float) -> None:
        """Handle an answer; an empty one, as without rosapi, is ignored."""
        name = answer.call.removeprefix(CALLS)
        if name in _QUESTIONS and answer.values is not None:
            self._answers[name] = answer.values, now_s

    def traffic(self, now_s: float) -> Traffic:
        kind = getattr(self._newest("topic_type", now_s), "type", "")
        kind = kind if isinstance(kind, str) else ""
        subscribers = self._nodes("subscribers", kind, now_s)
        publishers = self._nodes("publishers", kind, now_s)
        if publishers is not None:
            publishers = tuple(one for one in publishers if one.guid != self._node)
        return Traffic(subscribers, publishers, None)

    def _nodes(self, name: str, kind: str, now_s: float) -> tuple[Endpoint, ...] | None:
        nodes = getattr(self._newest(name, now_s), name, None)
        if not isinstance(nodes, list):
            return None
        return tuple(Endpoint(node, kind) for node in nodes if isinstance(node, str))

    def _newest(self, name: str, now_s: float) -> Any:
        values, at_s = self._answers.get(name, (None, -math.inf))
        return values if now_s - at_s < OLD_S else None
