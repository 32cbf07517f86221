"""Who else publishes commands, and whether those who listen take our type and stop as promised."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.robot.ros2.names import ros_type, same_type
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

OURS: Final = "wax"
"""How WAX marks the publisher of a driver, so that two servers know each other."""
STANDBY: Final = "wax-standby"
"""How it marks the publisher of a standby."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """A publisher or subscriber of the topic; `mark` says which of WAX's it is, if it is."""

    guid: str
    type_name: str
    mark: str = ""
    participant: str = ""


@dataclass(frozen=True, slots=True)
class Traffic:
    """All that is known of the topic; `matched` counts the subscribers that get what we send.

    `timeout_s` is after how long without a command the receiving side says that it stops; 0: never.
    None is unknown: a rosbridge server that has no `rosapi` beside it does not tell.
    """

    subscribers: tuple[Endpoint, ...] | None = None
    publishers: tuple[Endpoint, ...] | None = None
    matched: int | None = None
    timeout_s: float | None = None


def judge(
    traffic: Traffic, topic: str, type_name: str, ours: Collection[str], promised_s: float = 0.0
) -> Sentence | None:
    """Return why the robot cannot be driven, None if it can.

    `type_name` is what we send, as ROS 2 writes it; `ours` are the guids of our own publishers.
    `promised_s` is the time-out that the configuration names, 0 for none.
    """
    return (
        _others(traffic, topic, ours)
        or _received(traffic, topic, type_name)
        or _keeps(traffic.timeout_s, promised_s)
    )


def _keeps(timeout_s: float | None, promised_s: float) -> Sentence | None:
    """Say where the robot promises less than the host: the allowed speed is reckoned from that."""
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
    """Who took the commands at the last look: one who was not there then may be a base anew.

    A base that has crashed comes back as another subscriber, perhaps while a recorder subscribes
    on. Neither is told from the other, so a recorder that starts counts as a base, too.

    By rosbridge subscribers are nodes' names, asked for once a second: a base that comes back
    under its name before the next question is not noticed, nor anything without rosapi.
    """

    def __init__(self) -> None:
        self._known: frozenset[str] | None = None

    def forget(self) -> None:
        """Start over: whoever is there at the next look is not new."""
        self._known = None

    def has_new(self, traffic: Traffic, type_name: str) -> bool:
        """Note who takes what we send; return whether somebody came since the last look."""
        if traffic.subscribers is None:
            return False
        now = frozenset(
            subscriber.guid for subscriber in _of_our_type(traffic.subscribers, type_name)
        )
        known, self._known = self._known, now
        return known is not None and not now <= known


def _of_our_type(subscribers: Iterable[Endpoint], type_name: str) -> list[Endpoint]:
    """Return those of our type; one that is not told, as by a rosapi that refuses, may be it."""
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
