"""Cookies and tokens: whatever a browser presents, only those who were given one are admitted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tests.fuzz.target import Target
from tests.turned_clock import TurnedClock
from tests.visitors import make_access

from wax.access.access import Shown
from wax.errors import ForbiddenError
from wax.records.records import Records
from wax.web import cookies
from wax.web.request_head import Requests, read_head
from wax.web.senders import Proxies

if TYPE_CHECKING:
    from collections.abc import Sequence

_PROXIES: Final = Proxies(["127.0.0.1", "10.0.0.0/8"])

_CLOCK: Final = TurnedClock()
_ACCESS: Final = make_access(Records(_CLOCK), _CLOCK)
_IDENTITY: Final = _ACCESS.new_identity()
_NAME: Final = _ACCESS.identity_of(Shown(_IDENTITY))
_HOST: Final = _ACCESS.become_host(_ACCESS.new_host_link())
_INVITATION: Final = _ACCESS.invite("watch", uses=1000, valid_s=60)[0]
_ID: Final = _ACCESS.enter(_INVITATION, "ann").id


def _hear(data: bytes) -> None:
    # As aiohttp passes on a header's bytes.
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
        cookies.lacks_prefix(lines, scheme)


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


def _hear_heads(data: bytes) -> None:
    """Parse the requests of one connection, each with the body that its head announces."""
    requests = Requests()
    requests.add(data)
    given = 0
    while (head := requests.pop_head()) is not None:
        body = requests.pop(read_head(head).body_bytes)
        given += len(head) + len(body)
        _PROXIES.sender("127.0.0.1", *_forwarded(head))
    assert given + len(requests) <= len(data), "more than somebody sent"


def _forwarded(head: bytes) -> tuple[Sequence[str], Sequence[str]]:
    found = read_head(head)
    return found.x_forwarded_for, found.forwarded


HEADS: Final = Target(
    name="heads",
    what="requests, one behind the other",
    hear=_hear_heads,
    seeds=(
        b"GET / HTTP/1.1\r\nHost: a\r\nCookie: wax-id=x\r\n\r\n",
        b"POST /api/stop HTTP/1.1\r\nX-Forwarded-For: 192.0.2.7, 10.0.0.1\r\n"
        b"Content-Length: 2\r\n\r\n{}GET / HTTP/1.0\r\nForwarded: for=192.0.2.7\r\n\r\n",
    ),
    words=(
        b"\r\n",
        b"\r\n\r\n",
        b": ",
        b"Transfer-Encoding: chunked",
        b"for=",
        b"[::1]:",
        b"9" * 20,
    ),
    max_bytes=16_384,
)
