"""What is told to the records, and what they tell a server at its start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple


class Ban(NamedTuple):
    """An identity and an address that stay out until a time in seconds since 1970."""

    identity: str
    address: str
    until_s: float


class Invited(NamedTuple):
    """One use of an invitation, in force until a time in seconds since 1970."""

    invitation: str
    identity: str
    purpose: str
    until_s: float


class HostCookie(NamedTuple):
    """The hash of a host's cookie, in force until a time in seconds since 1970."""

    hash: str
    until_s: float


@dataclass(frozen=True, slots=True)
class Lasting:
    """What an earlier server has left in force."""

    bans: tuple[Ban, ...] = ()
    invited: tuple[Invited, ...] = ()
    host_cookies: tuple[HostCookie, ...] = ()


@dataclass(frozen=True, slots=True)
class LinkSummary:
    """How a viewer's link was: medians and the worst, None where nothing was measured."""

    round_trip_ms: float | None = None
    round_trip_worst_ms: float | None = None
    picture_age_ms: float | None = None
    picture_age_worst_ms: float | None = None
    sound_age_ms: float | None = None
    sound_age_worst_ms: float | None = None
    lost_percent: float | None = None
    lost_worst_percent: float | None = None
    rendition: str | None = None


@dataclass(frozen=True, slots=True)
class RecordedPerson:
    """Somebody as the records name them: `identity` is hashed before it is written."""

    identity: str
    name: str


NOBODY: Final = RecordedPerson("", "")
