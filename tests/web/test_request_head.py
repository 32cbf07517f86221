"""The bytes of a connection, cut where requests begin: nobody gets ahead of their own requests."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.web.request_head import MAX_HEAD_BYTES, Requests, read_head

GET = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"
POST = b"POST /api/stop HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\n"


@examples(100)
@given(st.lists(st.sampled_from([GET, POST + b"abc"]), max_size=6), st.data())
def test_requests_come_out_as_they_went_in(sent: list[bytes], data: st.DataObject) -> None:
    """However TCP cuts them, each head is one piece and has its own body behind it."""
    left = b"".join(sent)
    requests = Requests()
    got: list[bytes] = []
    while True:
        while (head := requests.take_head()) is not None:
            length = read_head(head).body_bytes or 0
            got.append(head)
            while length:
                if not requests:
                    requests.add(left[:1])
                    left = left[1:]
                piece = requests.take(length)
                got[-1] += piece
                length -= len(piece)
        if not left:
            break
        cut = data.draw(st.integers(1, len(left)))
        requests.add(left[:cut])
        left = left[cut:]
    assert got == sent
    assert len(requests) == 0


def test_a_head_has_an_end() -> None:
    """What has none within 16 KiB is full, and what begins as no request does is told at once."""
    requests = Requests()
    requests.add(b"GET / HTTP/1.1\r\nA: " + b"b" * (MAX_HEAD_BYTES - 20))
    assert requests.take_head() is None
    assert not requests.is_full
    requests.add(b"b" * 8)
    assert requests.is_full
    requests.add(b"\r\n\r\n")
    assert requests.take_head() is None, "one that is too long by what came last is no better"
    empty = Requests()
    empty.add(b"\r\n\r\n" + GET)
    assert empty.take_head() == GET
    tls = Requests()
    tls.add(b"\x16\x03\x01")
    assert tls.is_no_http


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (b"", 0),
        (b"Content-Length: 12\r\n", 12),
        (b"content-LENGTH:12\r\n", 12),
        (b"Content-Length: 1\r\nContent-Length: 1\r\n", None),
        (b"Content-Length: 0x1\r\n", None),
        (b"Content-Length: -1\r\n", None),
        (b"Content-Length: \xc2\xb2\r\n", None),
        (b"Content-Length: " + b"9" * 5000 + b"\r\n", None),
        (b"Transfer-Encoding: chunked\r\n", None),
        (b"Transfer-Encoding: chunked\r\nContent-Length: 4\r\n", None),
    ],
    ids=range(10),
)
def test_where_a_body_ends(lines: bytes, expected: int | None) -> None:
    """Only one plain length says so; behind anything else no further request is looked for."""
    assert read_head(b"POST / HTTP/1.1\r\n" + lines + b"\r\n").body_bytes == expected


def test_what_is_no_request_line_has_no_end() -> None:
    """The preface of HTTP/2 is for aiohttp to refuse, with what comes behind it."""
    assert read_head(b"PRI * HTTP/2.0\r\n\r\n").body_bytes is None


def test_who_asks() -> None:
    """Cookies and forwarded addresses are found however they are written, bytes included."""
    head = read_head(
        b"POST /api/stop HTTP/1.1\r\nCOOKIE: a=1\r\ncookie:b=\xff\r\nX-Forwarded-For: x\r\n"
        b"Forwarded: for=y\r\nCookie \r\n\r\n"
    )
    assert head.target == "POST /api/stop"
    assert head.cookies == ["a=1", "b=\udcff"]
    assert (head.x_forwarded_for, head.forwarded) == (["x"], ["for=y"])
