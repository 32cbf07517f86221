"""Checks the command topic: other publishers, and the subscribers' type and watchdog timeout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.robot.ros2.names import ros_type, same_type
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

OURS: Final = "wax"
"""The mark of a WAX driver's publisher, by which two servers recognise each other."""
STANDBY: Final = "wax-standby"
"""The mark of a standby's publisher."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """A publisher or subscriber of the topic; `mark` is set for WAX's own."""

    guid: str
    type_name: str
    mark: str = ""
    participant: str = ""


@dataclass(frozen=True, slots=True)
class Traffic:
    """All that is known of the topic; `matched` counts the subscribers that receive our messages.

    `timeout_s` is the command timeout that the receiving side reports; 0 means that it never stops.
    None means unknown, as for a rosbridge server without `rosapi`.
    """

    subscribers: tuple[Endpoint, ...] | None = None
    publishers: tuple[Endpoint, ...] | None = None
    matched: int | None = None
    timeout_s: float | None = None


def judge(
    traffic: Traffic, topic: str, type_name: str, ours: Collection[str], promised_s: float = 0.0
) -> Sentence | None:
    """Return why the robot cannot be driven, None if it can.

    `type_name` is our message type in ROS 2's notation; `ours` are the GUIDs of our own publishers.
    `promised_s` is the configured timeout, 0 for none.
    """
    return (
        _others(traffic, topic, ours)
        or _received(traffic, topic, type_name)
        or _keeps(traffic.timeout_s, promised_s)
    )


def _keeps(timeout_s: float | None, promised_s: float) -> Sentence | None:
    """Report a robot with a longer timeout than configured, on which the speed limit depends."""
    if timeout_s is None or promised_s <= 0.0 or 0.0 < timeout_s <= promised_s:
        return None
    return Sentence("ros2.other_timeout", {"theirs": timeout_s, "ours": promised_s})


def other_publishers(traffic: Traffic, ours: Collection[str]) -> list[Endpoint]:
    """Return who else publishes on the topic."""
    return [publisher for publisher in traffic.publishers or () if publisher.guid not in ours]


def _others(traffic: Traffic, topic: str, ours: Collection[str]) -> Sentence | None:
    others = other_publishers(traffic, ours)
    if not others:
        return None
    marks = {other.mark for other in others}
    if marks == {STANDBY}:
        return Sentence("ros2.standby_stops", {"topic": topic})
    if OURS in marks:
        return Sentence("ros2.other_wax", {"topic": topic})
    return Sentence("ros2.other_publisher", {"topic": topic, "n": len(others)})


class SubscribersSeen:
    """The subscribers at the last check: a new one since then may be a restarted base.

    A base that has crashed reappears as another subscriber, perhaps while a recorder stays
    subscribed. The two cannot be told apart, so a recorder that starts counts as a base, too.

    With rosbridge, subscribers are node names, polled once a second: a base that restarts between
    two polls is not noticed, and without rosapi no base is.
    """

    def __init__(self) -> None:
        self._known: frozenset[str] | None = None

    def forget(self) -> None:
        """Start over: no subscriber found at the next check counts as new."""
        self._known = None

    def has_new(self, traffic: Traffic, type_name: str) -> bool:
        """Record the present subscribers; return whether there is a new one."""
        if traffic.subscribers is None:
            return False
        now = frozenset(
            subscriber.guid for subscriber in _of_our_type(traffic.subscribers, type_name)
        )
        known, self._known = self._known, now
        return known is not None and not now <= known


def _of_our_type(subscribers: Iterable[Endpoint], type_name: str) -> list[Endpoint]:
    """Return those with our type; an unknown type, as without a rosapi answer, may be ours."""
    return [
        subscriber
        for subscriber in subscribers
        if not subscriber.type_name or same_type(ros_type(subscriber.type_name), type_name)
    ]


def _received(traffic: Traffic, topic: str, type_name: str) -> Sentence | None:
    if traffic.subscribers is None:
        return None
    takes_ours = _of_our_type(traffic.subscribers, type_name)
    if not traffic.subscribers:
        return Sentence("ros2.nobody_listens", {"topic": topic})
    if not takes_ours:
        theirs = ros_type(traffic.subscribers[0].type_name)
        return Sentence("ros2.wrong_type", {"topic": topic, "theirs": theirs, "ours": type_name})
    if traffic.matched == 0:
        return Sentence("ros2.wrong_qos", {"topic": topic})
    return None
