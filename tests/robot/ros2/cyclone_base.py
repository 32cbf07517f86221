"""A robot's base on CycloneDDS, in a process of its own: `python -m tests.robot.ros2.cyclone_base`.

usage: DOMAIN TOPIC twist|stamped reliable|best_effort

It writes what `fastdds_base.cpp` writes. A line of JSON on its input, ``[TYPE, TOPIC, {…}]``,
publishes a message, ``[TYPE, TOPIC]`` only makes a publisher. ``["parameter", NODE, NAME, VALUE]``
makes it answer for a node, as CycloneDDS's layer of ROS 2 does.
"""

from __future__ import annotations

import base64
import dataclasses
import json
import sys
import threading
import time
import typing
from typing import Any

from cyclonedds.core import Listener
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from wax.robot.ros2 import idl, names, parameters_idl
from wax.robot.ros2.cyclone_config import cyclone_config
from wax.robot.ros2.names import dds_topic

_LOCK = threading.Lock()


def say(line: str) -> None:
    with _LOCK:
        print(line, flush=True)  # noqa: T201 - the test reads it


class Wheels(Listener):
    def on_data_available(self, reader: DataReader[Any]) -> None:
        for message in reader.take(10):
            if not message.sample_info.valid_data:
                continue
            stamp_ns = 0
            twist = message
            if isinstance(message, idl.TwistStamped):
                stamp = message.header.stamp
                stamp_ns, twist = stamp.sec * 1_000_000_000 + stamp.nanosec, message.twist
            linear, angular = twist.linear, twist.angular
            speeds = f"{linear.x} {angular.z} {linear.y}"
            others = abs(linear.z) + abs(angular.x) + abs(angular.y)
            say(f"twist {time.monotonic_ns()} {stamp_ns} {speeds} {others}")

    def on_subscription_matched(self, reader: DataReader[Any], status: Any) -> None:
        say(f"matched {status.current_count}")


class Node(Listener):
    """Answers for one parameter; for any other the answer is empty, as rclcpp's is."""

    def __init__(self, member: DomainParticipant, node: str, name: str, value: float) -> None:
        super().__init__()  # type: ignore[no-untyped-call]  # cyclonedds has no type for it
        self._known = {name: value}
        qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
        asks: Any = parameters_idl.HeadedRequest
        answers: Any = parameters_idl.HeadedAnswer
        self._writer: DataWriter[Any] = DataWriter(
            member, Topic(member, f"rr{node}/get_parametersReply", answers), qos
        )
        self.reader: DataReader[Any] = DataReader(
            member, Topic(member, f"rq{node}/get_parametersRequest", asks), qos, listener=self
        )

    def on_data_available(self, reader: DataReader[Any]) -> None:
        for asked in reader.take(10):
            if asked.sample_info.valid_data:
                values = [
                    parameters_idl.ParameterValue(type=3, double_value=self._known[name])
                    for name in asked.names
                    if name in self._known
                ]
                # Another client's answer comes first: it must not count as ours.
                other = [parameters_idl.ParameterValue(type=3, double_value=99.0)]
                self._writer.write(parameters_idl.HeadedAnswer(asked.guid + 1, asked.seq, other))
                self._writer.write(parameters_idl.HeadedAnswer(asked.guid, asked.seq, values))


def build(kind: Any, values: dict[str, Any]) -> Any:
    """Make a message from JSON with some of its members."""
    hints = typing.get_type_hints(kind, include_extras=True)
    blank = kind()
    for name, value in values.items():
        setattr(blank, name, _member(getattr(blank, name), hints[name], value))
    return blank


def _member(old: Any, hint: Any, value: Any) -> Any:
    if dataclasses.is_dataclass(old):
        return build(type(old), value)
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [build(hint.__metadata__[0].subtype, one) for one in value]
    return base64.b64decode(value) if isinstance(value, str) and isinstance(old, bytes) else value


def main() -> None:
    number, topic, kind, reliability = int(sys.argv[1]), *sys.argv[2:5]
    domain = Domain(number, cyclone_config("127.0.0.1", []))
    member = DomainParticipant(number)
    reliable = Policy.Reliability.Reliable(duration(milliseconds=100))
    qos = Qos(
        reliable if reliability == "reliable" else Policy.Reliability.BestEffort,
        Policy.History.KeepLast(10),
    )
    twist: Any = idl.TYPES[names.TWIST_STAMPED if kind == "stamped" else names.TWIST]
    wheels: Any = Wheels  # its base is untyped
    reader: DataReader[Any] = DataReader(
        member, Topic(member, dds_topic(topic), twist), qos, listener=wheels()
    )
    writers: dict[str, DataWriter[Any]] = {}
    say("ready")
    nodes = []
    for line in sys.stdin:
        type_name, where, *values = json.loads(line)
        if type_name == "parameter":
            nodes.append(Node(member, where, *values))
            continue
        cls: Any = idl.TYPES[type_name]
        if where not in writers:
            writers[where] = DataWriter(member, Topic(member, dds_topic(where), cls), Qos(reliable))
        if values:
            writers[where].write(build(cls, values[0]))
    # A reader released during its callback would be deleted in it, and wait for itself.
    for told in (reader, *(node.reader for node in nodes)):
        told.set_listener(None)
    del told, reader, writers, nodes, domain


if __name__ == "__main__":
    main()
