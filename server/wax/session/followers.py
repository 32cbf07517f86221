"""Tells the programs that follow what the robot is sent; it is told nothing by them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.control.listener import Listener
from wax.errors import ForbiddenError
from wax.protocol import messages
from wax.sentence import Sentence
from wax.session.record_keeper import name_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.control.gate import Setpoint
    from wax.driver.interface import Twist
    from wax.session.viewer import Viewer


MOST: Final = 4
"""Each gets up to twenty messages a second, which take a third of a millisecond each."""


class Followers(Listener):
    """Keeps the newest set-point, and sends it on when it has changed."""

    def __init__(self, viewers: Iterable[Viewer]) -> None:
        self._viewers = viewers
        self._newest: tuple[Setpoint, Twist, int, float] | None = None
        self._told_s: dict[int, float] = {}

    def add(self, viewer: Viewer) -> None:
        """Let a viewer follow until they disconnect; raises `ForbiddenError` if enough do."""
        if not viewer.follows and sum(one.follows for one in self._viewers) >= MOST:
            raise ForbiddenError(Sentence("follow.full", {"n": MOST}))
        viewer.follows = True

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None:
        # Fifty times a second, whether anybody follows or not.
        newest = self._newest
        if newest is None or (wanted, sent, turn) != newest[:3]:
            self._newest = wanted, sent, turn, now_s

    def send_changes(self) -> None:
        """Send each follower the newest set-point, unless they have it."""
        following = [one for one in self._viewers if one.follows]
        if following and self._newest is not None:
            at_s, text = self._newest[-1], _driven(*self._newest).model_dump_json()
            for viewer in following:
                if self._told_s.get(viewer.number) != at_s:
                    viewer.send_text(text)
            self._told_s = dict.fromkeys((one.number for one in following), at_s)
        else:
            self._told_s = {}


def _driven(wanted: Setpoint, sent: Twist, turn: int, at_s: float) -> messages.Driven:
    return messages.Driven(
        server_ms=at_s * 1000,
        turn=turn,
        linear_mps=sent.linear_mps,
        angular_rps=sent.angular_rps,
        lateral_mps=sent.lateral_mps,
        reason=None if wanted.reason is None else name_of(wanted.reason),
        limit=None if wanted.limit is None else name_of(wanted.limit),
    )
