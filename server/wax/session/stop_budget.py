"""Who may press Stop, on the data channel or by HTTP; the latch decides who may release it.

Everybody may press Stop, even people who want nobody to drive. Each person has a budget, and
each address has one for all of its people together, in which every press counts, even the first:
otherwise forty browsers at one address would press forty times a minute. Part of it is reserved for
the first press a minute of known viewers: the few who have watched longest from that address, for
at least `KNOWN_S`. So a viewer who was here before a flood of new browsers can still press.

The price: a newcomer at an address whose budget others have just used up is refused. It takes an
attacker at their own address, who has just stopped the robot as often as that budget allows. The
operator's and the host's own presses always count, and so do everybody's at other addresses.
A press that leaves the Stop in force as it is costs nothing. The page repeats a press, on both
ways, until it is answered; a repetition has the same number, stops nothing anew, and costs nothing.
The host sees the presses by address, since browsers are cheap, and can ignore an address.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.bounded_dict import BoundedDict
from wax.control.reasons import Refusal
from wax.errors import ForbiddenError
from wax.rate_limits import MinuteLimits
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.access.admission import Visitor
    from wax.control.stop_latch import Releaser
    from wax.protocol.events import StopRole
    from wax.session.parts import Parts
    from wax.session.presence import Presence
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
"""Per address; fewer if its budget is small."""
_MOST: Final = 1024
_MOST_TOLD: Final = 8
_TOLD_S: Final = 600.0


@dataclass(slots=True)
class PressingAddress:
    """An address that has pressed Stop; `by` is the last person, `presses` has refused ones too."""

    number: int
    address: str
    by: Sentence
    presses: int = 0
    newest_s: float = 0.0


class StopBudget:
    """Passes a press to the latch if its sender may press, is not muted, and has budget left."""

    def __init__(self, parts: Parts, presence: Presence) -> None:
        settings = self._settings = parts.settings.stop
        self._clock = parts.clock
        self._decisions = parts.decisions
        self._turns = parts.turns
        self._control = parts.control
        self._keeper = parts.keeper
        self._presence = presence
        address = settings.max_per_minute_per_address
        self._most_known = max(1, min(MOST_KNOWN, address // 2))
        self._people = MinuteLimits(each=settings.max_per_minute, most=_MOST)
        self._addresses = MinuteLimits(each=max(1, address - self._most_known), most=_MOST)
        self._pressers: dict[str, PressingAddress] = {}  # the newest last
        self._numbers = 0
        self._taken = BoundedDict[tuple[str, int | None], int](_MOST)  # by person and press
        self._in_force: StopRole | None = None

    @property
    def in_force(self) -> StopRole | None:
        """The role that pressed the Stop in force, "host" once the host has pressed it, too."""
        return self._in_force

    def press(self, viewer: Viewer | None, press: int | None = None, *, is_host: bool) -> int:
        """Latch the stop before anything else; returns its number. Raises `ForbiddenError`.

        `viewer` is None for a host without a page, `press` if the sender does not number presses.
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
        """Do the same for somebody who watches in a LiveKit room."""
        key = (visitor.identity, press)
        if (taken := self._taken.get(key)) is not None:
            return taken
        self._check(None, visitor, FROM_ROOM)
        return self._press(None, FROM_ROOM, "observer", key)

    def press_from_house(self) -> int:
        """Do the same for the host's home automation, which does not say who pressed."""
        return self._press(None, HOUSE, "house")

    def restore(self, role: StopRole) -> None:
        """Latch the stop that was in force when the last server ended."""
        self._press(None, {"host": HOST, "house": HOUSE}.get(role, BEFORE), role)

    def release(
        self, viewer: Viewer | None, stop: int, sent_s: float | None, *, is_host: bool
    ) -> None:
        """Release the stop with this number; raises `ForbiddenError` with the reason."""
        by: Releaser = "host" if is_host else None if viewer is None else viewer.number
        self._release(viewer, by, stop, sent_s, self._role(viewer, is_host))

    def release_from_house(self, age_s: float) -> None:
        """Release the Stop in force by a request of this age; raises `ForbiddenError`.

        The age is by the sender's clock: while it differs from ours, pressing again is in vain.
        """
        stop, sent_s = self._control.latched, self._clock.now_s() - age_s
        said = {
            Refusal.RELEASED_LATE: Sentence("house.release_late", {"s": round(age_s, 1)}),
            Refusal.FROM_FUTURE: Sentence("house.release_early", {"s": round(-age_s, 2)}),
        }
        self._release(None, "house", 0 if stop is None else stop.number, sent_s, "house", said=said)

    def pressers(self) -> list[PressingAddress]:
        """Return the addresses that pressed in the last ten minutes, or are muted; newest first.

        The operator's and the host's own presses are left out.
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
        self._keeper.stop_pressed(viewer, str(by), number, role)
        if key[1] is not None:
            self._taken[key] = number
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
        self._count_press(visitor.address, by, now_s)
        decisions = self._decisions
        if visitor.identity in decisions.muted or visitor.address in decisions.muted_addresses:
            raise ForbiddenError(MUTED)
        is_free = self._control.would_add_nothing(None if viewer is None else viewer.number)
        if not is_free and not self._has_budget(visitor, now_s):
            raise ForbiddenError(TOO_OFTEN)

    def _has_budget(self, visitor: Visitor, now_s: float) -> bool:
        """Whether this press counts; one beyond the person's budget costs their address nothing."""
        own = self._people.taken(visitor.identity, now_s)
        return (
            own < self._settings.max_per_minute
            and (
                visitor.is_known  # nobody gets many of these, as of browsers
                or self._addresses.take(visitor.address, now_s)
                or (own == 0 and self._is_known(visitor, now_s))
            )
            and self._people.take(visitor.identity, now_s)
        )

    def _is_known(self, visitor: Visitor, now_s: float) -> bool:
        """Whether somebody is among the few of their address who have watched longest."""
        since = {
            who: (since_s, who)
            for who, since_s in self._presence.watches_from(visitor.address).items()
        }
        own = since.get(visitor.identity)
        if own is None or now_s - own[0] < KNOWN_S:
            return False
        return sum(other < own for other in since.values()) < self._most_known

    def _count_press(self, address: str, by: Sentence, now_s: float) -> None:
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
