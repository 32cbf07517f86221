"""Cookies and tokens: whatever a browser shows, nobody is let in who was not given them."""

from __future__ import annotations

from typing import Final

from tests.fuzz.target import Target
from tests.turned_clock import TurnedClock
from tests.visitors import make_access

from wax.access.access import Shown
from wax.errors import ForbiddenError
from wax.records.records import Records
from wax.web import cookies

_CLOCK: Final = TurnedClock()
_ACCESS: Final = make_access(Records(_CLOCK), _CLOCK)
_IDENTITY: Final = _ACCESS.new_identity()
_NAME: Final = _ACCESS.identity_of(Shown(_IDENTITY))
_HOST: Final = _ACCESS.become_host(_ACCESS.new_host_link())
_INVITATION: Final = _ACCESS.invite("watch", uses=1000, valid_s=60)[0]
_ID: Final = _ACCESS.enter(_INVITATION, "ann").id


def _hear(data: bytes) -> None:
    # As aiohttp hands a header's bytes on.
    text = data.decode("utf-8", "surrogateescape")
    visitor = _ACCESS.visitor(Shown(identity=text, host=text), "192.0.2.1")
    assert visitor.is_host is (text == _HOST), "somebody became the host"
    assert visitor.identity in ("", _NAME), "somebody made an identity"
    try:
        _ACCESS.become_host(text)
    except ForbiddenError:
        pass
    else:
        raise AssertionError("a link was guessed")
    try:
        entered = _ACCESS.enter(text, "ann")
    except ForbiddenError:
        return
    assert entered.id == _ID, "somebody made an invitation"


TOKENS: Final = Target(
    name="tokens",
    what="cookies and invitations",
    hear=_hear,
    seeds=tuple(one.encode() for one in (_IDENTITY, _HOST, _INVITATION)),
    words=(b".", b"..", b"=", b"\xff", b"\x00", b"eJw", b"e30", b"-", b"_", b"A" * 64),
    max_bytes=1024,
)


def _hear_headers(data: bytes) -> None:
    text = data.decode("utf-8", "surrogateescape")
    lines = text.splitlines()
    for scheme in ("http", "https"):
        shown = cookies.shown(lines, scheme)
        told = sum(len(cookie or "") for cookie in (shown.identity, shown.host))
        assert told <= len(text), "more than somebody sent"
        cookies.to_rename(lines, scheme)


COOKIES: Final = Target(
    name="cookies",
    what="Cookie headers, a line each",
    hear=_hear_headers,
    seeds=(
        b"wax-id=abc.def; wax-host=ghi.jkl",
        b'other="a b"; wax-id=x\nwax-host=y',
    ),
    words=(b"wax-id=", b"__Host-wax-id=", b"; ", b'="', b"\n", b"\\054", b"$Path", b"Secure;"),
    max_bytes=8192,
)
