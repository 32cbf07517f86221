"""The values that are recorded, and those that a server loads when it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple


class Ban(NamedTuple):
    """A banned identity and address, until a time in seconds since 1970."""

    identity: str
    address: str
    until_s: float


class Invited(NamedTuple):
    """One use of an invitation, valid until a time in seconds since 1970."""

    invitation: str
    identity: str
    purpose: str
    until_s: float


class HostCookie(NamedTuple):
    """The hash of a host's cookie, valid until a time in seconds since 1970."""

    hash: str
    until_s: float


@dataclass(frozen=True, slots=True)
class Lasting:
    """The entries of earlier servers that are still in force."""

    bans: tuple[Ban, ...] = ()
    invited: tuple[Invited, ...] = ()
    host_cookies: tuple[HostCookie, ...] = ()


@dataclass(frozen=True, slots=True)
class LinkSummary:
    """The quality of a viewer's link: medians and worst values, None if not measured."""

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
    """A person as recorded: `identity` is hashed before it is written."""

    identity: str
    name: str


NOBODY: Final = RecordedPerson("", "")
