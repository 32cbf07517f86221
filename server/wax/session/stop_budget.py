"""Who may press Stop, on the data channel or by HTTP; the latch decides who may release it.

Everybody may press Stop, also those who want nobody to drive. Each person has a budget, and
each address has one for all of its people together, in which every press counts, the first one too:
otherwise forty browsers of one address would press forty times a minute. Part of it is kept for the
first press a minute of those who are known: the few who have watched longest from there, and for at
least `KNOWN_S`. So whoever was here before a flood of new browsers stops the robot all the same.

The price: somebody new, at an address whose budget others have just used up, is not heard. It takes
an attacker at their own address, and the robot was stopped twelve times within that minute. The
operator's and the host's own presses always count, and so do everybody's at other addresses.
A press that leaves the stop in force as it is costs nothing. One that comes again, since the page
sends it by both ways and until it is answered, is the same press: it has its number, stops nothing
anew, and costs nothing.
The host sees who presses, by address, since browsers are cheap, and can ignore an address.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.control.reasons import Refusal
from wax.errors import ForbiddenError
from wax.sentence import Sentence
from wax.session.minute_limits import MinuteLimits

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from wax.access.admission import Visitor
    from wax.clock import Clock
    from wax.config.settings import StopSettings
    from wax.control.loop import ControlLoop
    from wax.control.stop_latch import Releaser
    from wax.control.turns import Turns
    from wax.protocol.events import StopRole
    from wax.session.host_decisions import HostDecisions
    from wax.session.record_keeper import RecordKeeper
    from wax.session.viewer import Viewer

ONLY_THE_OPERATOR_STOPS: Final = Sentence("stop.only_operator")
MUTED: Final = Sentence("stop.muted")
HOST: Final = Sentence("by.host")
FROM_ROOM: Final = Sentence("by.in_room")
BEFORE: Final = Sentence("by.before")
HOUSE: Final = Sentence("by.house")
TOO_OFTEN: Final = Sentence("stop.too_often")

KNOWN_S: Final = 10.0
MOST_KNOWN: Final = 8
"""Of one address; fewer where its budget is small."""
_MOST: Final = 1024
_MOST_TOLD: Final = 8
_TOLD_S: Final = 600.0


@dataclass(slots=True)
class PressingAddress:
    """An address that has pressed Stop: `by` whom last, and how often, refused `presses` too."""

    number: int
    address: str
    by: Sentence
    presses: int = 0
    newest_s: float = 0.0


class StopBudget:
    """Lets through to the latch whoever may press Stop: by role, not ignored, within the budget.

    `keep` hears of each change of the latch. `watch` returns who watches from an address, by
    identity, and since when.
    """

    def __init__(
        self,
        *,
        settings: StopSettings,
        clock: Clock,
        decisions: HostDecisions,
        turns: Turns,
        control: ControlLoop,
        keeper: RecordKeeper,
        keep: Callable[[], None],
        watch: Callable[[str], Mapping[str, float]],
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._decisions = decisions
        self._turns = turns
        self._control = control
        self._keeper = keeper
        self._keep = keep
        self._watch = watch
        address = settings.max_per_minute_per_address
        self._most_known = max(1, min(MOST_KNOWN, address // 2))
        self._people = MinuteLimits(each=settings.max_per_minute, most=_MOST)
        self._addresses = MinuteLimits(each=max(1, address - self._most_known), most=_MOST)
        self._pressers: dict[str, PressingAddress] = {}  # the newest last
        self._numbers = 0
        self._taken: dict[tuple[str, int | None], int] = {}  # by person and press; the newest last
        self._in_force: StopRole | None = None

    @property
    def in_force(self) -> StopRole | None:
        """The role of who pressed the stop in force; the host's, once they have pressed, too."""
        return self._in_force

    def press(self, viewer: Viewer | None, press: int | None = None, *, is_host: bool) -> int:
        """Latch the stop before anything else; returns its number. Raises `ForbiddenError`.

        `viewer` is None for a host without a page, `press` for one who does not number them.
        """
        key = ("" if viewer is None else viewer.visitor.identity, press)
        if (taken := self._taken.get(key)) is not None:
            return taken
        drives = viewer is not None and viewer.number == self._turns.operator
        by = HOST if viewer is None else _named(viewer)
        if not (drives or is_host):
            self._check(viewer, None if viewer is None else viewer.visitor, by)
        return self._press(viewer, by, self._role(viewer, is_host), key)

    def press_from_room(self, visitor: Visitor, press: int | None = None) -> int:
        """Do the same for somebody who watches in a room of the cluster."""
        key = (visitor.identity, press)
        if (taken := self._taken.get(key)) is not None:
            return taken
        self._check(None, visitor, FROM_ROOM)
        return self._press(None, FROM_ROOM, "observer", key)

    def press_from_house(self) -> int:
        """Do the same for the host's home automation, which says nothing of who presses there."""
        return self._press(None, HOUSE, "house")

    def press_again(self, role: StopRole) -> None:
        """Latch the stop that was in force when the last server ended."""
        self._press(None, {"host": HOST, "house": HOUSE}.get(role, BEFORE), role)

    def release(
        self, viewer: Viewer | None, stop: int, sent_s: float | None, *, is_host: bool
    ) -> None:
        """Release the stop with this number; raises `ForbiddenError` with the reason."""
        by: Releaser = "host" if is_host else None if viewer is None else viewer.number
        self._release(viewer, by, stop, sent_s, self._role(viewer, is_host))

    def release_from_house(self, age_s: float) -> None:
        """Release the stop in force, as that was wanted so long ago; raises `ForbiddenError`.

        The age is by the sender's clock: where it differs from ours, to press again is in vain.
        """
        stop, sent_s = self._control.latched, self._clock.now_s() - age_s
        said = {
            Refusal.RELEASED_LATE: Sentence("house.release_late", {"s": round(age_s, 1)}),
            Refusal.FROM_FUTURE: Sentence("house.release_early", {"s": round(-age_s, 2)}),
        }
        self._release(None, "house", 0 if stop is None else stop.number, sent_s, "house", said=said)

    def pressers(self) -> list[PressingAddress]:
        """Return the addresses of the last ten minutes, and those that are ignored; newest first.

        Without the operator's and the host's own presses.
        """
        since_s, muted = self._clock.now_s() - _TOLD_S, self._decisions.muted_addresses
        told = [one for one in self._pressers.values() if one.newest_s >= since_s]
        told += [one for one in self._pressers.values() if one.address in muted and one not in told]
        return told[::-1]

    def mute(self, number: int, is_muted: bool) -> None:
        """Ignore the Stop of everybody at a presser's address, or heed it again."""
        for one in self._pressers.values():
            if one.number == number:
                if is_muted:
                    self._decisions.muted_addresses.add(one.address)
                else:
                    self._decisions.muted_addresses.discard(one.address)

    def _press(
        self,
        viewer: Viewer | None,
        by: Sentence,
        role: StopRole,
        key: tuple[str, int | None] = ("", None),
    ) -> int:
        number = self._control.press_stop(
            by,
            viewer=None if viewer is None else viewer.number,
            by_host=role == "host",
            release_after_s=self._settings.release_after_s,
        )
        self._in_force = "host" if role == "host" else self._in_force or role
        self._keep()
        self._keeper.stop_pressed(viewer, str(by), number, role)
        if key[1] is not None:
            self._taken[key] = number
            if len(self._taken) > _MOST:
                del self._taken[next(iter(self._taken))]
        return number

    def _release(
        self,
        viewer: Viewer | None,
        by: Releaser,
        stop: int,
        sent_s: float | None,
        role: StopRole,
        *,
        said: Mapping[Refusal, Sentence] | None = None,
    ) -> None:
        refusal = self._control.release_stop(by, stop, sent_s)
        if refusal is not None:
            raise ForbiddenError((said or {}).get(refusal, refusal.value))
        self._in_force = None
        self._keep()
        name = str(HOUSE if by == "house" else HOST) if viewer is None else viewer.name
        self._keeper.stop_released(viewer, name, stop, role)

    def _role(self, viewer: Viewer | None, is_host: bool) -> StopRole:
        if is_host:
            return "host"
        drives = viewer is not None and viewer.number == self._turns.operator
        return "operator" if drives else "observer"

    def _check(self, viewer: Viewer | None, visitor: Visitor | None, by: Sentence) -> None:
        if visitor is None or self._settings.by != "everybody":
            raise ForbiddenError(ONLY_THE_OPERATOR_STOPS)
        now_s = self._clock.now_s()
        self._note(visitor.address, by, now_s)
        decisions = self._decisions
        if visitor.identity in decisions.muted or visitor.address in decisions.muted_addresses:
            raise ForbiddenError(MUTED)
        is_free = self._control.would_add_nothing(None if viewer is None else viewer.number)
        if not is_free and not self._has_budget(visitor, now_s):
            raise ForbiddenError(TOO_OFTEN)

    def _has_budget(self, visitor: Visitor, now_s: float) -> bool:
        """Whether this press counts; one beyond a person's own costs their address nothing."""
        own = self._people.taken(visitor.identity, now_s)
        return (
            own < self._settings.max_per_minute
            and (
                self._addresses.take(visitor.address, now_s)
                or (own == 0 and self._is_known(visitor, now_s))
            )
            and self._people.take(visitor.identity, now_s)
        )

    def _is_known(self, visitor: Visitor, now_s: float) -> bool:
        """Whether somebody is among the few of their address who have watched longest."""
        since = {who: (since_s, who) for who, since_s in self._watch(visitor.address).items()}
        own = since.get(visitor.identity)
        if own is None or now_s - own[0] < KNOWN_S:
            return False
        return sum(other < own for other in since.values()) < self._most_known

    def _note(self, address: str, by: Sentence, now_s: float) -> None:
        one = self._pressers.pop(address, None)
        if one is None:
            self._numbers += 1
            one = PressingAddress(self._numbers, address, by)
        one.by, one.presses, one.newest_s = by, one.presses + 1, now_s
        self._pressers[address] = one
        heeded = [each for each in self._pressers if each not in self._decisions.muted_addresses]
        if len(heeded) > _MOST_TOLD:
            del self._pressers[heeded[0]]


def _named(viewer: Viewer) -> Sentence:
    return Sentence("by.named", {"name": viewer.name})
