"""Cookies: ours are found among any number, and under HTTPS no neighbour can plant them."""

from __future__ import annotations

import pytest
from aiohttp import web
from tests.turned_clock import TurnedClock
from tests.visitors import make_access

from wax.access.access import Shown
from wax.records.records import Records
from wax.web import cookies


@pytest.mark.parametrize(
    ("headers", "scheme", "expected"),
    [
        ([], "http", Shown()),
        (["wax-id=a; wax-host=b"], "http", Shown("a", "b")),
        (["x=1;wax-id=a", 'wax-host="b";=;;wax-id'], "http", Shown("a", "b")),
        (["wax-id=a; wax-id=z"], "http", Shown("a")),
        (["__Host-wax-id=a"], "http", Shown()),
        (["__Host-wax-id=~a; __Host-wax-host=b"], "https", Shown("~a", "b")),
        (["wax-id=planted; __Host-wax-id=~a"], "https", Shown("~a")),
        (["wax-id=old; wax-host=old"], "https", Shown("old", "old")),
        (["wax-id=~planted"], "https", Shown()),
        (["n=1;" * 5000 + "wax-id=a"], "http", Shown()),
    ],
)
def test_what_a_browser_shows(headers: list[str], scheme: str, expected: Shown) -> None:
    """Under HTTPS the names that no other site can set come first, and the old ones last."""
    assert cookies.shown(headers, scheme) == expected


def test_a_neighbour_cannot_plant_an_identity() -> None:
    """What is given under HTTPS counts under its own name only, and cannot be made to count."""
    clock = TurnedClock()
    access = make_access(Records(clock), clock)
    given = access.new_identity(bound=True)
    assert access.identity_of(cookies.shown([f"__Host-wax-id={given}"], "https"))
    assert not access.identity_of(cookies.shown([f"wax-id={given}"], "https"))
    assert not access.identity_of(cookies.shown([f"wax-id={given[1:]}"], "https"))


@pytest.mark.parametrize(("scheme", "name"), [("http", "wax-host"), ("https", "__Host-wax-host")])
def test_how_cookies_are_given(scheme: str, name: str) -> None:
    """With the prefix they must be secure, for all paths and for no other host (RFC 6265bis)."""
    answer = web.Response()
    cookies.give_host(answer, "b", scheme)
    given = answer.cookies[name]
    assert (given.value, given["path"], given["domain"]) == ("b", "/", "")
    assert (bool(given["secure"]), given["httponly"]) == (scheme == "https", True)
    assert given["samesite"] == "Strict"
    if scheme == "https":
        assert answer.cookies["wax-host"]["max-age"] == "0", "the old name goes"


def test_who_is_renamed() -> None:
    """Only whoever shows no new name, and only under HTTPS."""
    assert cookies.to_rename(["wax-id=a"], "https")
    assert not cookies.to_rename(["wax-id=a; __Host-wax-id=b"], "https")
    assert not cookies.to_rename(["wax-id=a"], "http")
