"""The direct connection by DDS, using CycloneDDS."""

from __future__ import annotations

import struct
import time
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Any, Final

from cyclonedds.core import (
    DDSException,
    InstanceState,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from wax.robot.ros2 import idl
from wax.robot.ros2.command_topic import Traffic
from wax.robot.ros2.dds_domain import participant, told
from wax.robot.ros2.dds_endpoints import Endpoints
from wax.robot.ros2.dds_timeouts import ReceiverTimeouts
from wax.robot.ros2.link import command_type
from wax.robot.ros2.names import dds_topic

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.driver.interface import Twist
    from wax.robot.ros2.link import Wanted
    from wax.robot.ros2.settings import Ros2Settings

BLOCK_S: Final = 0.02
"""How long a write may block; with a history of one sample it replaces that instead."""
ACKNOWLEDGED_S: Final = 0.2
_TAKEN: Final = 16
_DAMAGED: Final = (ValueError, AssertionError, IndexError, struct.error)
"""What cyclonedds raises for bytes that are not a valid message."""
_ANY: Final = SampleState.Any | ViewState.Any | InstanceState.Any


class DdsLink:
    """A `Link` of one participant, with a writer if it has a `mark`."""

    def __init__(
        self,
        settings: Ros2Settings,
        clock: Clock,
        *,
        mark: str = "",
        wanted: Sequence[Wanted] = (),
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._is_closed = False
        self.invalid = 0
        self._held = ExitStack()
        try:
            self._open(mark, wanted)
        except BaseException:
            self._held.close()
            raise

    def _open(self, mark: str, wanted: Sequence[Wanted]) -> None:
        member = self._held.enter_context(participant(self._settings))
        with told(self._settings):
            self._writer = self._commands(member, mark) if mark else None
            self._guid = str(self._writer.guid) if self._writer is not None else ""
            name = dds_topic(self._settings.topic)
            self._subscribers = Endpoints(member, name, publishers=False)
            self._timeouts = ReceiverTimeouts(member)
            self._publishers = Endpoints(member, name, publishers=True)
            self._readers = {want.kind: _reader(member, want) for want in wanted}
            self._news = WaitSet(member)
            self._conditions = [ReadCondition(reader, _ANY) for reader in self._readers.values()]
            for condition in self._conditions:
                self._news.attach(condition)

    @property
    def guid(self) -> str:
        return self._guid

    def send(self, twist: Twist, wall_ns: int) -> None:
        if self._writer is None:
            return
        said = idl.TwistMessage(
            linear=idl.Vector3(x=twist.linear_mps, y=twist.lateral_mps),
            angular=idl.Vector3(z=twist.angular_rps),
        )
        with told(self._settings):
            self._writer.write(self._stamped(said, wall_ns) if self._settings.stamped else said)

    def take(self, timeout_s: float) -> list[tuple[str, Any]]:
        if not self._conditions:
            time.sleep(timeout_s)  # CycloneDDS returns at once if it has nothing to wait for
            return []
        with told(self._settings):
            self._news.wait(duration(seconds=timeout_s))
            return [
                (kind, message)
                for kind, reader in self._readers.items()
                for message in self._messages(reader)
            ]

    def traffic(self) -> Traffic:
        with told(self._settings):
            writer = self._writer
            matched = None if writer is None else len(writer.get_matched_subscriptions())
            subscribers, publishers = self._subscribers.read(), self._publishers.read()
            return Traffic(subscribers, publishers, matched, self._timeout_s())

    def _timeout_s(self) -> float | None:
        if self._writer is None:
            return None
        return self._timeouts.poll(self._subscribers.parameter_services(), self._clock.now_s())

    def close(self) -> None:
        if self._is_closed:
            return
        self._is_closed = True
        if self._writer is not None:
            # A failure changes nothing here; on a timeout cyclonedds raises a wrong exception.
            with suppress(DDSException, AttributeError):
                self._writer.wait_for_acks(duration(seconds=ACKNOWLEDGED_S))
        # CycloneDDS deletes entities without references.
        self._writer = None
        self._conditions.clear()
        self._readers.clear()
        del self._subscribers, self._publishers, self._news, self._timeouts
        self._held.close()

    def _commands(self, member: Any, mark: str) -> DataWriter[Any]:
        offered = (
            Policy.Reliability.Reliable(duration(seconds=BLOCK_S))
            if self._settings.reliability == "reliable"
            else Policy.Reliability.BestEffort
        )
        qos = Qos(
            offered,
            Policy.History.KeepLast(1),
            Policy.Durability.Volatile,
            Policy.Userdata(mark.encode()),
            _XCDR1,
        )
        kind = idl.TYPES[command_type(self._settings)]
        return DataWriter(member, Topic(member, dds_topic(self._settings.topic), kind), qos)

    def _stamped(self, said: idl.TwistMessage, wall_ns: int) -> idl.TwistStamped:
        sec, nanosec = divmod(wall_ns, 1_000_000_000)
        return idl.TwistStamped(idl.Header(idl.Time(sec, nanosec), self._settings.frame_id), said)

    def _messages(self, reader: DataReader[Any]) -> list[Any]:
        """Read the queued messages one by one; those that cannot be decoded are only counted."""
        messages = []
        for _ in range(_TAKEN):
            try:
                taken = reader.take(1)
            except _DAMAGED:
                self.invalid += 1
                continue
            if not taken:
                break
            messages += [message for message in taken if message.sample_info.valid_data]
        return messages


_XCDR1: Final = Policy.DataRepresentation(use_cdrv0_representation=True)
"""The representation that every ROS 2 system uses."""


def _reader(member: Any, want: Wanted) -> DataReader[Any]:
    """Subscribe with best effort, which matches every publisher."""
    qos = Qos(
        Policy.Reliability.BestEffort,
        Policy.History.KeepLast(_DEPTHS.get(want.kind, 1)),
        Policy.Durability.Volatile,
        _XCDR1,
    )
    return DataReader(member, Topic(member, dds_topic(want.topic), idl.TYPES[want.type_name]), qos)


_DEPTHS: Final = {"bumper": 8, "diagnostics": 8}
"""The history depth of kinds whose messages do not replace each other."""
