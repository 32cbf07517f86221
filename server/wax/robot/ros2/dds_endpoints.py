"""Publishers and subscribers of one topic, as DDS's discovery reports them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState

from wax.robot.ros2.command_topic import Endpoint

if TYPE_CHECKING:
    from cyclonedds.domain import DomainParticipant

_SERVICE: Final = re.compile(r"rq(/.+)/get_parametersRequest")
_AT_ONCE: Final = 256
_ALIVE: Final = InstanceState.Alive


class Endpoints:
    """Tracks the publishers or subscribers of `topic`; endpoints of other topics are read once.

    A large robot has thousands of endpoints, so only changes are read.
    """

    def __init__(self, participant: DomainParticipant, topic: str, *, publishers: bool) -> None:
        which = BuiltinTopicDcpsPublication if publishers else BuiltinTopicDcpsSubscription
        self._topic = topic
        self._reader = BuiltinDataReader(participant, which)
        self._news = ReadCondition(
            self._reader, SampleState.NotRead | ViewState.Any | InstanceState.Any
        )
        self._known: dict[str, Endpoint] = {}
        self._services: dict[str, tuple[str, str]] = {}

    def read(self) -> tuple[Endpoint, ...]:
        """Read the changes and return the present endpoints."""
        while news := self._reader.read(_AT_ONCE, self._news):
            for found in news:
                self._note(found)
        return tuple(self._known.values())

    def parameter_services(self) -> dict[str, str]:
        """Return the nodes in the subscribers' processes, with their parameter services' GUIDs.

        All nodes of a process share one participant, so they cannot be told apart.
        """
        beside = {known.participant for known in self._known.values()}
        return {node: guid for guid, (node, process) in self._services.items() if process in beside}

    def _note(self, found: Any) -> None:
        guid = str(found.key)
        if found.sample_info.instance_state != _ALIVE:
            self._known.pop(guid, None)
            self._services.pop(guid, None)
        elif found.topic_name == self._topic:
            process = str(found.participant_key)
            self._known[guid] = Endpoint(guid, found.type_name, _mark(found), process)
        elif (service := _SERVICE.fullmatch(found.topic_name)) is not None:
            self._services[guid] = service[1], str(found.participant_key)


def _mark(found: Any) -> str:
    told = [policy.data for policy in found.qos if type(policy).__name__ == "Userdata"]
    return told[0].decode("ascii", "replace") if told else ""
