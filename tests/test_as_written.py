"""URLs that other programs compare or have signed."""

from __future__ import annotations

import pytest
from aiohttp import InvalidURL

from wax.as_written import as_written


@pytest.mark.parametrize(
    "path",
    [
        "/tok%7Een%2Dx%2Fy",
        "/h?sig=A%2Fd%2Be%3D&&x=&q=a+b%20c",
        "/a%28b%29/../c//d",
        "/?x=%C3%BC",
        "/?next=https://a.example/b",
    ],
)
def test_path_and_query_stay_as_they_are(path: str) -> None:
    """Path, query and password are kept as written; a password is decoded to be sent (RFC 7617)."""
    made = as_written(f"wss://me:p%40s%2F@Robot.Example:9090{path}")
    assert made.raw_path_qs == path
    assert (made.user, made.password, made.host, made.port) == (
        *("me", "p@s/"),
        *("robot.example", 9090),
    )


@pytest.mark.parametrize(("rest", "asked"), [("", "/"), ("?a=%2F", "/?a=%2F"), ("/%2F#b", "/%2F")])
def test_an_address_may_end_early(rest: str, asked: str) -> None:
    """A URL may end after its host; its fragment is not sent."""
    assert as_written(f"http://[::1]:8080{rest}").raw_path_qs == asked


def test_what_is_no_address_raises() -> None:
    """An invalid URL raises `InvalidURL`."""
    with pytest.raises(InvalidURL):
        as_written("http://home:99999/")
