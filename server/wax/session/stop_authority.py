"""Who may press Stop, on the data channel or by HTTP; the latch decides who may release it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.errors import ForbiddenError
from wax.sentence import Sentence
from wax.session.token_bucket import TokenBuckets

if TYPE_CHECKING:
    from wax.access.admission import Visitor
    from wax.clock import Clock
    from wax.config.settings import StopSettings
    from wax.control.loop import ControlLoop
    from wax.control.stop_latch import Releaser
    from wax.control.turns import Turns
    from wax.session.house import House
    from wax.session.record_keeper import RecordKeeper
    from wax.session.viewer import Viewer

ONLY_THE_OPERATOR_STOPS: Final = Sentence("stop.only_operator")
MUTED: Final = Sentence("stop.muted")
HOST: Final = Sentence("by.host")
ELSEWHERE: Final = Sentence("by.elsewhere")
TOO_OFTEN: Final = Sentence("stop.too_often")

_MOST: Final = 1024
_MINUTE_S: Final = 60.0


class StopAuthority:
    """Checks requests to the stop latch.

    The operator's and the host's own presses always count. Of the others' each person has a budget,
    and so has each address; a person's first press counts even where the address has used up its.
    """

    def __init__(
        self,
        *,
        settings: StopSettings,
        clock: Clock,
        house: House,
        turns: Turns,
        control: ControlLoop,
        keeper: RecordKeeper,
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._house = house
        self._turns = turns
        self._control = control
        self._keeper = keeper
        person, address = settings.max_per_minute, settings.max_per_minute_per_address
        self._first = TokenBuckets(rate_hz=1 / _MINUTE_S, burst=1, most=_MOST)
        self._people = TokenBuckets(rate_hz=person / _MINUTE_S, burst=person, most=_MOST)
        self._addresses = TokenBuckets(rate_hz=address / _MINUTE_S, burst=address, most=_MOST)

    def press(self, viewer: Viewer | None, *, is_host: bool) -> int:
        """Latch the stop before anything else; returns its number. Raises `ForbiddenError`.

        `viewer` is None for a host without a page.
        """
        drives = viewer is not None and viewer.number == self._turns.operator
        if not (drives or is_host):
            self._check(None if viewer is None else viewer.visitor)
        return self._press(viewer, HOST if viewer is None else _named(viewer), is_host=is_host)

    def press_elsewhere(self, visitor: Visitor) -> int:
        """Do the same for somebody who watches in a room of the cluster."""
        self._check(visitor)
        return self._press(None, ELSEWHERE, is_host=False)

    def release(
        self, viewer: Viewer | None, stop: int, sent_s: float | None, *, is_host: bool
    ) -> None:
        """Release the stop with this number; raises `ForbiddenError` with the reason."""
        by: Releaser = "host" if is_host else None if viewer is None else viewer.number
        refusal = self._control.release_stop(by, stop, sent_s)
        if refusal is not None:
            raise ForbiddenError(refusal.value)
        self._keeper.stop_released(str(HOST) if viewer is None else viewer.name)

    def _press(self, viewer: Viewer | None, by: Sentence, *, is_host: bool) -> int:
        number = self._control.press_stop(
            by, viewer=None if viewer is None else viewer.number, by_host=is_host
        )
        self._keeper.stop_pressed(viewer, str(by), number)
        return number

    def _check(self, visitor: Visitor | None) -> None:
        if visitor is None or self._settings.by != "everybody":
            raise ForbiddenError(ONLY_THE_OPERATOR_STOPS)
        if visitor.identity in self._house.muted:
            raise ForbiddenError(MUTED)
        if not self._has_budget(visitor):
            raise ForbiddenError(TOO_OFTEN)

    def _has_budget(self, visitor: Visitor) -> bool:
        now_s = self._clock.now_s()
        is_first = self._first.take(visitor.identity, now_s)
        is_within = self._people.take(visitor.identity, now_s)
        return (self._addresses.take(visitor.address, now_s) and is_within) or is_first


def _named(viewer: Viewer) -> Sentence:
    return Sentence("by.named", {"name": viewer.name})
