"""Who is admitted (opening hours, bans of a day), and with which rights."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from ipaddress import ip_network
from typing import TYPE_CHECKING, Final

from wax.access.vouching import NOT_SIGNED_IN
from wax.errors import FullError, NotAdmittedError
from wax.protocol.messages import Opening
from wax.records.entries import Ban
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from wax.access.host_decisions import HostDecisions
    from wax.access.vouching import Right, Vouched
    from wax.config.access import AccessSettings
    from wax.config.opening_hours import OpeningHours
    from wax.protocol.http_bodies import Purpose

BAN_S: Final = 86_400.0
BY_INVITATION: Final = Sentence("door.by_invitation")
BANNED: Final = Sentence("door.banned")
LOCKED: Final = Sentence("door.locked")
CLOSED: Final = Sentence("door.closed")
TOO_MANY_TABS: Final = Sentence("door.too_many_tabs")


@dataclass(frozen=True, slots=True)
class Visitor:
    """Somebody who asks for admission: a browser's identity, address and credentials.

    `address` is what limits count: an IPv4 address or an IPv6 /64 prefix. `sign_in` is the host's
    by a link, empty for others. An embed is a page in another site's frame; it has an identity of
    its own without a cookie. `vouched` is what a trusted proxy says, None where none is asked;
    `device` is then the browser's own identity, empty if it keeps no cookies.
    """

    identity: str
    address: str
    sign_in: str = ""
    invited_to: Purpose | None = None
    is_embed: bool = False
    vouched: Vouched | None = None
    device: str = ""

    @property
    def is_host(self) -> bool:
        return bool(self.sign_in) or self.right == "host"

    @property
    def is_known(self) -> bool:
        """Whether a trusted proxy says who this is, and nothing refuses them."""
        return self.vouched is not None and self.vouched.refusal is None

    @property
    def is_invited(self) -> bool:
        """Whether they come in by more than what is open to strangers."""
        return self.invited_to is not None or self.right in ("drive", "watch")

    @property
    def right(self) -> Right:
        """What their groups at the proxy allow."""
        return "stranger" if self.vouched is None else self.vouched.right

    def proves(self, other: Visitor) -> bool:
        """Whether this one's request shows that the other is still signed in: one browser's is."""
        return self.identity == other.identity and self.device in ("", other.device)


@dataclass(frozen=True, slots=True)
class Grant:
    """A viewer's rights in the room."""

    hear: bool
    queue: bool


_EVERYTHING: Final = Grant(hear=True, queue=True)


class Admission:
    """Decides by configuration, opening hours, bans, and whether the host has closed or locked.

    Times are in seconds since 1970.
    """

    def __init__(
        self,
        settings: AccessSettings,
        hours: OpeningHours,
        decisions: HostDecisions,
        bans: Iterable[Ban] = (),
    ) -> None:
        self._settings = settings
        self._hours = hours
        self._decisions = decisions
        self._bans = list(bans)

    def ban(self, visitor: Visitor, now_s: float) -> Ban:
        """Ban a browser and its address, or a person whom a proxy knows, for a day.

        This machine's own address is exempt: everybody behind an untrusted proxy has it.
        """
        is_shared = visitor.is_known or _is_loopback(visitor.address)
        address = "" if is_shared else visitor.address
        ban = Ban(visitor.identity, address, now_s + BAN_S)
        self._bans.append(ban)
        return ban

    def close(self, is_closed: bool, now_s: float) -> None:
        """Close to guests until the next opening hours begin, or reopen."""
        opens = self._hours.opens_next(_at(now_s)) if is_closed else None
        until_s = None if opens is None else opens.timestamp()
        self._decisions.switches = self._decisions.switches.model_copy(
            update={"is_closed": is_closed, "closed_until_s": until_s}
        )

    def is_open(self, now_s: float) -> bool:
        """Whether guests are admitted now."""
        return not self._is_closed(now_s) and self._hours.is_open(_at(now_s))

    def opens_s(self, now_s: float) -> float | None:
        """Return when guests are next admitted; None if they are now, or if unknown."""
        if self.is_open(now_s):
            return None
        if self._is_closed(now_s):
            return self._decisions.switches.closed_until_s
        opens = self._hours.opens_next(_at(now_s))
        return None if opens is None else opens.timestamp()

    def check(self, visitor: Visitor, now_s: float) -> Grant:
        """Return a visitor's rights; raises `NotAdmittedError` with a sentence for them."""
        if visitor.is_host:
            return _EVERYTHING
        self.check_vouched(visitor)
        self._bans = [one for one in self._bans if now_s < one.until_s]
        if any(_is_meant(one, visitor) for one in self._bans):
            raise NotAdmittedError(BANNED)
        if not self.is_open(now_s):
            raise NotAdmittedError(CLOSED, self._openings(now_s))
        if visitor.right != "stranger":
            return Grant(hear=True, queue=visitor.right == "drive")
        settings = self._settings
        if visitor.invited_to is not None:
            return Grant(hear=True, queue=visitor.invited_to == "queue" or settings.strangers_queue)
        if self._decisions.switches.is_locked:
            raise NotAdmittedError(LOCKED)
        if not settings.strangers_watch:
            raise NotAdmittedError(BY_INVITATION)
        return Grant(hear=settings.strangers_hear, queue=settings.strangers_queue)

    def check_vouched(self, visitor: Visitor) -> None:
        """Raise `NotAdmittedError` if a proxy should say who this guest is, and does not."""
        if self._settings.proxy.is_used and not (visitor.is_host or visitor.is_known):
            refusal = None if visitor.vouched is None else visitor.vouched.refusal
            raise NotAdmittedError(refusal or NOT_SIGNED_IN)

    def check_tabs(self, visitor: Visitor, inside: Sequence[Visitor]) -> None:
        """Raise `FullError` if this browser has its maximum of open pages."""
        own = visitor.identity, visitor.device
        count = sum((one.identity, one.device) == own for one in inside)
        if not visitor.is_host and count >= self._settings.max_tabs:
            raise FullError(TOO_MANY_TABS)

    def _is_closed(self, now_s: float) -> bool:
        """Whether the host has closed, and the hours that end this have not begun."""
        switches = self._decisions.switches
        until_s = switches.closed_until_s
        return switches.is_closed and (until_s is None or now_s < until_s)

    def _openings(self, now_s: float) -> list[Opening]:
        return [
            Opening(
                opens_wall_ms=opens.timestamp() * 1000, closes_wall_ms=closes.timestamp() * 1000
            )
            for opens, closes in self._hours.openings(_at(now_s))
        ]


def _is_meant(ban: Ban, visitor: Visitor) -> bool:
    same_address = bool(ban.address) and ban.address == visitor.address
    return ban.identity == visitor.identity or same_address


def _is_loopback(address: str) -> bool:
    try:
        return ip_network(address).is_loopback
    except ValueError:
        return False


def _at(now_s: float) -> datetime:
    return datetime.fromtimestamp(now_s, UTC)
