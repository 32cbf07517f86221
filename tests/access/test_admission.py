"""Admission: who is let in, and with which rights."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any
from zoneinfo import ZoneInfo

import pytest

from wax.access.admission import (
    BAN_S,
    BANNED,
    BY_INVITATION,
    CLOSED,
    LOCKED,
    Admission,
    Grant,
    Visitor,
)
from wax.access.host_decisions import HostDecisions
from wax.config.access import AccessSettings
from wax.config.opening_hours import OpeningHours
from wax.errors import FullError, NotAdmittedError
from wax.protocol.host_switches import HostSwitches

MONDAY_S = datetime(2026, 11, 23, 12, 0, tzinfo=UTC).timestamp()
HOUR_S = 3600.0
HOST = Visitor("host", "192.0.2.1", "a sign-in")
ANN = Visitor("ann", "192.0.2.1")
FRIEND = Visitor("friend", "198.51.100.1", invited_to="queue")
GUEST = Visitor("guest", "198.51.100.1", invited_to="watch")
TROLL = Visitor("troll", "203.0.113.1")


def make(*hours: str, is_locked: bool = False, **settings: Any) -> Admission:
    checked = AccessSettings.model_validate(settings)
    decisions = HostDecisions(HostSwitches(is_locked=is_locked))
    return Admission(checked, OpeningHours.of(hours, ZoneInfo("UTC")), decisions)


def refused(door: Admission, visitor: Visitor, now_s: float = MONDAY_S) -> NotAdmittedError:
    with pytest.raises(NotAdmittedError) as found:
        door.check(visitor, now_s)
    return found.value


def test_by_default_strangers_may_do_everything_a_viewer_does() -> None:
    """By default, anyone with the link is admitted with all of a viewer's rights."""
    assert make().check(ANN, MONDAY_S) == Grant(hear=True, queue=True)


@pytest.mark.parametrize(
    ("settings", "stranger", "guest", "friend"),
    [
        ({"strangers_queue": False}, (True, False), (True, False), (True, True)),
        ({"strangers_hear": False}, (False, True), (True, True), (True, True)),
        ({"strangers_watch": False}, None, (True, True), (True, True)),
        (
            {"strangers_watch": False, "strangers_queue": False},
            None,
            (True, False),
            (True, True),
        ),
    ],
)
def test_what_strangers_and_the_invited_may(
    settings: dict[str, bool],
    stranger: tuple[bool, bool] | None,
    guest: tuple[bool, bool],
    friend: tuple[bool, bool],
) -> None:
    """An invitation gives the rights in it, and never fewer than a stranger's."""
    door = make(**settings)
    if stranger is None:
        assert refused(door, ANN).sentence == BY_INVITATION
    else:
        assert door.check(ANN, MONDAY_S) == Grant(*stranger)
    assert door.check(GUEST, MONDAY_S) == Grant(*guest)
    assert door.check(FRIEND, MONDAY_S) == Grant(*friend)
    assert door.check(HOST, MONDAY_S) == Grant(hear=True, queue=True)


def test_a_lock_keeps_the_invited() -> None:
    """A lock keeps out strangers and admits the invited."""
    door = make(is_locked=True)
    assert refused(door, ANN).sentence == LOCKED
    assert door.check(GUEST, MONDAY_S).hear
    assert door.check(HOST, MONDAY_S).queue


def test_a_ban_is_for_a_browser_and_its_address() -> None:
    """A ban refuses the identity at any address, and the address for any identity, for a day."""
    door = make()
    ban = door.ban(TROLL, MONDAY_S)
    for one in (TROLL, Visitor("new", TROLL.address), Visitor("troll", "192.0.2.99")):
        assert refused(door, one).sentence == BANNED
    assert door.check(Visitor("new", "192.0.2.99"), MONDAY_S).queue
    assert door.check(TROLL, MONDAY_S + BAN_S).queue
    again = Admission(
        AccessSettings(), OpeningHours.of((), ZoneInfo("UTC")), HostDecisions(), [ban]
    )
    assert refused(again, TROLL).sentence == BANNED  # the server was restarted


@pytest.mark.parametrize("address", ["127.0.0.1", "::/64", "", "no address"])
def test_this_machines_address_is_never_banned(address: str) -> None:
    """A ban exempts loopback addresses: everybody behind an untrusted proxy has one."""
    door = make()
    door.ban(Visitor("troll", address if address != "::/64" else "::1/128"), MONDAY_S)
    assert door.check(Visitor("ann", "127.0.0.1"), MONDAY_S).queue


def test_a_host_cannot_lock_themselves_out() -> None:
    """A host who bans their own address is still admitted."""
    door = make()
    door.ban(ANN, MONDAY_S)
    assert door.check(HOST, MONDAY_S).queue


def test_outside_the_hours_only_the_host_comes_in() -> None:
    """Outside opening hours, guests are refused with the next ones; the host is admitted."""
    door = make("mon-fri 09:00-11:00")
    for one in (ANN, FRIEND):
        error = refused(door, one)
        assert error.sentence == CLOSED
        first, *others = error.openings
        assert first.opens_wall_ms == (MONDAY_S + 21 * HOUR_S) * 1000
        assert first.closes_wall_ms == (MONDAY_S + 23 * HOUR_S) * 1000
        assert len(others) == 4
    assert door.check(HOST, MONDAY_S).queue
    assert door.check(ANN, MONDAY_S + 21 * HOUR_S).queue


def test_the_host_closes_for_the_day() -> None:
    """A closed robot reopens with its next opening hours, or when the host reopens it."""
    door = make("mon-fri 09:00-18:00")
    door.close(True, MONDAY_S)
    assert not door.is_open(MONDAY_S + 5 * HOUR_S)
    assert door.opens_s(MONDAY_S) == MONDAY_S + 21 * HOUR_S
    assert door.is_open(MONDAY_S + 21 * HOUR_S)
    door.close(True, MONDAY_S)
    door.close(False, MONDAY_S)
    assert door.check(ANN, MONDAY_S).queue


def test_without_hours_the_host_opens() -> None:
    """Without opening hours, a closed robot names no time of reopening."""
    door = make()
    door.close(True, MONDAY_S)
    assert refused(door, ANN).openings == []
    assert not door.is_open(MONDAY_S + 1000 * HOUR_S)


def test_ten_tabs_are_too_many() -> None:
    """One person's tabs are limited, since each has a peer connection of its own."""
    door = make(max_tabs=4)
    with pytest.raises(FullError, match="close another tab"):
        door.check_tabs(ANN, [ANN] * 4)
    door.check_tabs(ANN, [ANN, ANN, ANN, TROLL])
    door.check_tabs(HOST, [HOST] * 9)
