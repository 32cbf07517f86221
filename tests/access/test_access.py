"""Identities, hosts and invitations together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from tests.turned_clock import TurnedClock
from tests.visitors import make_access

from wax.access.access import Access, Shown
from wax.access.secret_file import load_secret
from wax.errors import ForbiddenError
from wax.records.entries import Invited, Lasting
from wax.records.records import Records

if TYPE_CHECKING:
    from pathlib import Path


class Wall(TurnedClock):
    """A fake clock whose wall time advances with it."""

    def wall_ms(self) -> int:
        return int(self.time_s * 1000)


def make(clock: TurnedClock, lasting: Lasting | None = None) -> Access:
    return make_access(Records(clock, lasting or Lasting()), clock, secret=b"s" * 32)


def test_a_browser_is_who_its_cookie_says() -> None:
    """A browser has the identity in its cookie, and none without a cookie that we signed."""
    access = make(Wall())
    cookie = access.new_identity()
    visitor = access.visitor(Shown(cookie), "192.0.2.1")
    assert visitor.identity == access.identity_of(Shown(cookie)) != ""
    for other in (None, "", "made up", cookie[:-1], "x" + cookie):
        assert access.visitor(Shown(other), "192.0.2.1").identity == ""


def test_a_host_link_works_once() -> None:
    """A link's secret gives one cookie; a used or invented one is refused with advice."""
    access = make(Wall())
    secret = access.new_host_link()
    cookie = access.become_host(secret)
    assert access.visitor(Shown(host=cookie), "").is_host
    for again in (secret, "made up", ""):
        with pytest.raises(ForbiddenError, match="wax host-link"):
            access.become_host(again)


def test_two_hosts() -> None:
    """Each link makes a host, without ending another's sign-in."""
    access = make(Wall())
    cookies = [access.become_host(access.new_host_link()) for _ in range(2)]
    assert all(access.visitor(Shown(host=one), "").is_host for one in cookies)


def test_a_host_s_cookie_is_renewed_as_it_is_used() -> None:
    """A replaced cookie stays valid for a minute, for other tabs that are using it."""
    clock = Wall()
    access = make(clock)
    old = access.become_host(access.new_host_link())
    new = access.renew_cookie(Shown(host=old))
    assert new is not None
    assert access.visitor(Shown(host=old), "").is_host
    clock.time_s += 61.0
    assert not access.visitor(Shown(host=old), "").is_host
    assert access.visitor(Shown(host=new), "").is_host


def test_an_invitation_is_used_as_often_as_it_says() -> None:
    """An invitation admits its number of people; each may return, in other tabs, too."""
    access = make(Wall())
    token, _ = access.invite("queue", uses=2, valid_s=600)
    for identity in ("ann", "bob", "ann", "bob"):
        assert access.enter(token, identity).purpose == "queue"
    with pytest.raises(ForbiddenError, match="used up"):
        access.enter(token, "eve")


def test_who_is_refused_leaves_nothing() -> None:
    """Refused attempts on a used-up invitation store nothing, however many browsers try."""
    access = make(Wall())
    token, _ = access.invite("queue", uses=1, valid_s=600)
    access.enter(token, "ann")
    for number in range(3):
        with pytest.raises(ForbiddenError, match="used up"):
            access.enter(token, f"eve {number}")
    assert list(access._invited) == ["ann"]


def test_uses_outlast_the_server() -> None:
    """The uses of an invitation survive a restart."""
    clock = Wall()
    token, ends_s = make(clock).invite("watch", uses=1, valid_s=600)
    probe = make(clock)
    used = Invited(probe.enter(token, "ann").id, "ann", "watch", ends_s)
    access = make(clock, Lasting(invited=(used,)))
    access.enter(token, "ann")
    with pytest.raises(ForbiddenError, match="used up"):
        access.enter(token, "eve")


def test_the_larger_invitation_counts_until_it_ends() -> None:
    """Of two invitations, the one to queue counts until it expires, then the one to watch."""
    clock = Wall()
    access = make(clock)
    for purpose, valid_s in (("watch", 600), ("queue", 60)):
        access.enter(access.invite(purpose, uses=1, valid_s=valid_s)[0], "ann")  # type: ignore[arg-type]
    visitor = access.refreshed(access.visitor(Shown(), "192.0.2.1"))
    assert visitor.invited_to is None
    assert access._invited_to("ann") == "queue"
    clock.time_s += 61.0
    assert access._invited_to("ann") == "watch"
    clock.time_s += 600.0
    assert access._invited_to("ann") is None


def test_the_secret_outlasts_the_server(tmp_path: Path) -> None:
    """The secret is created once, readable by its owner only; a damaged one is replaced."""
    first = load_secret(str(tmp_path))
    assert load_secret(str(tmp_path)) == first
    path = tmp_path / "secret"
    assert path.stat().st_mode & 0o777 == 0o600
    path.write_bytes(b"cut")
    assert load_secret(str(tmp_path)) != first


def test_without_a_folder_the_secret_lasts_as_long_as_the_server(tmp_path: Path) -> None:
    """A secret that cannot be stored is logged and works until the server ends."""
    (tmp_path / "file").write_text("")
    assert len(load_secret(str(tmp_path / "file" / "x"))) == 32
