"""Cookies: ours are found among any number, and under HTTPS no other site can plant them."""

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
    """Under HTTPS, the names that no other site can set take precedence over the old ones."""
    assert cookies.shown(headers, scheme) == expected


def test_another_site_cannot_plant_an_identity() -> None:
    """An identity given under HTTPS counts only under the prefixed name, even without its mark."""
    clock = TurnedClock()
    access = make_access(Records(clock), clock)
    given = access.new_identity(bound=True)
    assert access.identity_of(cookies.shown([f"__Host-wax-id={given}"], "https"))
    assert not access.identity_of(cookies.shown([f"wax-id={given}"], "https"))
    assert not access.identity_of(cookies.shown([f"wax-id={given[1:]}"], "https"))


@pytest.mark.parametrize(("scheme", "name"), [("http", "wax-host"), ("https", "__Host-wax-host")])
def test_the_attributes_of_cookies(scheme: str, name: str) -> None:
    """Prefixed cookies must be secure, for all paths and for no other host (RFC 6265bis)."""
    answer = web.Response()
    cookies.set_host(answer, "b", scheme)
    given = answer.cookies[name]
    assert (given.value, given["path"], given["domain"]) == ("b", "/", "")
    assert (bool(given["secure"]), given["httponly"]) == (scheme == "https", True)
    assert given["samesite"] == "Strict"
    if scheme == "https":
        assert answer.cookies["wax-host"]["max-age"] == "0", "the old name goes"


def test_which_cookies_lack_the_prefix() -> None:
    """Only identities without a prefixed cookie do, and only under HTTPS."""
    assert cookies.lacks_prefix(["wax-id=a"], "https")
    assert not cookies.lacks_prefix(["wax-id=a; __Host-wax-id=b"], "https")
    assert not cookies.lacks_prefix(["wax-id=a"], "http")
