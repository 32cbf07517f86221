"""Asks one node for parameters, one after the other, without blocking."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Any, Final

from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from wax.robot.ros2 import parameters_idl as idl

if TYPE_CHECKING:
    from cyclonedds.domain import DomainParticipant

_QOS: Final = Qos(
    Policy.Reliability.Reliable(duration(milliseconds=20)),
    Policy.History.KeepLast(10),
    Policy.Durability.Volatile,
    Policy.DataRepresentation(use_cdrv0_representation=True),
)
_CYCLONE: Final = "0110"
"""The prefix of CycloneDDS's identifiers."""
_INTEGER: Final = 2
_DOUBLE: Final = 3


class ParameterClient:
    """A client of one node's parameter service; `server` is the identifier of its subscriber."""

    def __init__(self, member: DomainParticipant, node: str, server: str) -> None:
        self._is_headed = server.startswith(_CYCLONE)
        asks: Any = idl.HeadedRequest if self._is_headed else idl.Request
        answers: Any = idl.HeadedAnswer if self._is_headed else idl.ParametersAnswer
        service = f"{node}/get_parameters"
        self._writer: DataWriter[Any] = DataWriter(
            member, Topic(member, f"rq{service}Request", asks), _QOS
        )
        self._reader: DataReader[Any] = DataReader(
            member, Topic(member, f"rr{service}Reply", answers), _QOS
        )
        self._guid = secrets.randbits(63)
        self._seq = 0

    @property
    def is_ready(self) -> bool:
        """Whether both topics are matched, so that no message is lost."""
        return bool(
            self._writer.get_matched_subscriptions() and self._reader.get_matched_publications()
        )

    def ask(self, name: str) -> None:
        """Ask for one parameter: a node that lacks one of several returns none of them."""
        self._reader.take(10)
        self._seq += 1
        request = (
            idl.HeadedRequest(self._guid, self._seq, [name])
            if self._is_headed
            else idl.Request([name])
        )
        self._writer.write(request)

    def answer(self) -> tuple[bool, float | None]:
        """Return whether the answer has arrived, and the number in it, None if there is none."""
        for found in self._reader.take(10):
            if found.sample_info.valid_data and self._is_ours(found):
                return True, _number(found.values)
        return False, None

    def _is_ours(self, found: Any) -> bool:
        # Without a header every client of the node receives every answer; skip foreign ones.
        if self._is_headed:
            return (found.guid, found.seq) == (self._guid, self._seq)
        return len(found.values) <= 1


def _number(values: Any) -> float | None:
    if len(values) != 1:
        return None
    (value,) = values
    if value.type == _DOUBLE:
        return float(value.double_value)
    return float(value.integer_value) if value.type == _INTEGER else None
