"""Publishers and subscribers of one topic, as DDS's discovery reports them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState

from wax.robot.ros2.neighbours import Endpoint

if TYPE_CHECKING:
    from cyclonedds.domain import DomainParticipant

_AT_ONCE: Final = 256
_ALIVE: Final = InstanceState.Alive


class Endpoints:
    """Keeps who publishes on, or subscribes to, `topic`; other topics are only looked at once.

    A large robot has thousands of endpoints, so only news are read.
    """

    def __init__(self, participant: DomainParticipant, topic: str, *, publishers: bool) -> None:
        which = BuiltinTopicDcpsPublication if publishers else BuiltinTopicDcpsSubscription
        self._topic = topic
        self._reader = BuiltinDataReader(participant, which)
        self._news = ReadCondition(
            self._reader, SampleState.NotRead | ViewState.Any | InstanceState.Any
        )
        self._known: dict[str, Endpoint] = {}

    def look(self) -> tuple[Endpoint, ...]:
        """Read the news and return who is there."""
        while news := self._reader.read(_AT_ONCE, self._news):
            for found in news:
                self._note(found)
        return tuple(self._known.values())

    def _note(self, found: Any) -> None:
        guid = str(found.key)
        if found.sample_info.instance_state != _ALIVE:
            self._known.pop(guid, None)
        elif found.topic_name == self._topic:
            self._known[guid] = Endpoint(guid, found.type_name, _mark(found))


def _mark(found: Any) -> str:
    told = [policy.data for policy in found.qos if type(policy).__name__ == "Userdata"]
    return told[0].decode("ascii", "replace") if told else ""
