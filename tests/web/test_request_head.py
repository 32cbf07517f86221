"""The bytes of a connection are split into its requests, one after another."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples
from tests.rtc.steps import counted

from wax.web.request_head import MAX_HEAD_BYTES, Requests, read_head

GET = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"
POST = b"POST /api/stop HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\n"


@examples(100)
@given(st.lists(st.sampled_from([GET, POST + b"abc"]), max_size=6), st.data())
def test_requests_are_split_as_they_were_sent(sent: list[bytes], data: st.DataObject) -> None:
    """However TCP cuts them, each head comes out whole, followed by its own body."""
    left = b"".join(sent)
    requests = Requests()
    got: list[bytes] = []
    while True:
        while (head := requests.pop_head()) is not None:
            length = read_head(head).body_bytes or 0
            got.append(head)
            while length:
                if not requests:
                    requests.add(left[:1])
                    left = left[1:]
                piece = requests.pop(length)
                got[-1] += piece
                length -= len(piece)
        if not left:
            break
        cut = data.draw(st.integers(1, len(left)))
        requests.add(left[:cut])
        left = left[cut:]
    assert got == sent
    assert len(requests) == 0


def test_a_head_must_end_within_16_kib() -> None:
    """A longer head is full, and a start unlike any request's is detected at once."""
    requests = Requests()
    requests.add(b"GET / HTTP/1.1\r\nA: " + b"b" * (MAX_HEAD_BYTES - 20))
    assert requests.pop_head() is None
    assert not requests.is_full
    requests.add(b"b" * 8)
    assert requests.is_full
    requests.add(b"\r\n\r\n")
    assert requests.pop_head() is None, "a head that its last bytes make too long is refused, too"
    empty = Requests()
    empty.add(b"\r\n\r\n" + GET)
    assert empty.pop_head() == GET
    tls = Requests()
    tls.add(b"\x16\x03\x01")
    assert tls.is_not_http


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
    """Only one plain length tells; after anything else, no further request is parsed."""
    assert read_head(b"POST / HTTP/1.1\r\n" + lines + b"\r\n").body_bytes == expected


def test_without_a_request_line_the_body_has_no_known_end() -> None:
    """The preface of HTTP/2 and everything after it are left for aiohttp to refuse."""
    assert read_head(b"PRI * HTTP/2.0\r\n\r\n").body_bytes is None


@pytest.mark.parametrize(
    "sent",
    [b"\r\n" * 131_072, b"GET / HTTP/1.1\r\n" + b"A:\r\n" * 4000 + b"\r\n"],
    ids=["empty lines", "short headers"],
)
def test_thousands_of_lines_cost_no_more_than_few(sent: bytes) -> None:
    """Neither empty lines before a request nor the shortest headers are handled one by one."""
    requests = Requests()
    requests.add(sent)
    with counted() as steps:
        if (head := requests.pop_head()) is not None:
            read_head(head)
    assert steps.count < 5000


@pytest.mark.parametrize(
    ("request_line", "is_long"),
    [
        (b"GET /assets/index-Y8n9_ePO.js HTTP/1.1", False),
        (b"GET /?fbclid=" + b"a" * 4000 + b" HTTP/1.1", False),
        (b"GET " + b"/" * 300 + b" HTTP/1.1", True),
        (b"GET  " + b"/" * 300 + b"?a HTTP/1.1", True),
        (b"GET http://a" + b"/a" * 150 + b" HTTP/1.1", True),
    ],
)
def test_only_the_path_must_be_short(request_line: bytes, is_long: bool) -> None:
    """Each slash of a path costs a search for a route; other sites add long queries to links."""
    assert read_head(request_line + b"\r\n\r\n").has_long_path == is_long


def test_the_sender_of_a_head() -> None:
    """Cookies and forwarded addresses are found in any case, non-ASCII bytes included."""
    head = read_head(
        b"POST /api/stop HTTP/1.1\r\nCOOKIE: a=1\r\ncookie:b=\xff\r\nX-Forwarded-For: x\r\n"
        b"Forwarded: for=y\r\nWAX-Tab: ada's \xff\r\nCookie \r\n\r\n"
    )
    assert head.target == "POST /api/stop"
    assert head.cookies == ["a=1", "b=\udcff"]
    assert head.tab == "ada's \udcff"
    assert (head.x_forwarded_for, head.forwarded) == (["x"], ["for=y"])
