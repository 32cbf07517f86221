"""The attackers' bytes: RTCP, SCTP, HTTP. Pure, and without any of the server's code.

The server's parsers must not judge themselves: a mistake that both ends shared would go unnoticed.
"""

from __future__ import annotations

import re
from struct import pack
from typing import Final

from google_crc32c import value as crc32c

_MORE_LINES: Final = 100

# --- RTCP ---------------------------------------------------------------------------------


def rtcp(count: int, kind: int, body: bytes) -> bytes:
    """Return one packet (RFC 3550, 6.4.1); `body` has whole words."""
    return pack("!BBH", 0x80 | count, kind, len(body) // 4) + body


def announces_lost(first: int, packets: int) -> bytes:
    """Return transport-wide feedback that reports `packets` lost, beginning with `first`."""
    runs = [min(0x1FFF, packets - at) for at in range(0, packets, 0x1FFF)]
    chunks = b"".join(pack("!H", run) for run in runs)
    chunks += bytes(-len(chunks) % 4)
    head = pack("!LLHHL", 1, 1, first & 0xFFFF, packets, 0)
    return rtcp(15, 205, head + chunks)


def nack(ssrc: int, newest: int, packets: int) -> bytes:
    """Return a NACK for `packets` up to `newest`, seventeen in four bytes (RFC 4585, 6.2.1)."""
    firsts = range(newest - packets + 1, newest + 1, 17)
    wanted = b"".join(pack("!HH", first & 0xFFFF, 0xFFFF) for first in firsts)
    return rtcp(1, 205, pack("!LL", 1, ssrc) + wanted)


def receiver_report(ssrc: int) -> bytes:
    """Return a report about nobody: the shortest valid RTCP (RFC 3550, 6.4.2)."""
    return rtcp(0, 201, pack("!L", ssrc))


# --- SCTP ---------------------------------------------------------------------------------


def sctp(tag: int, chunks: bytes) -> bytes:
    """Return a packet of the association with this tag (RFC 9260, 3.1)."""
    head = pack("!HHL", 5000, 5000, tag)
    return head + pack("<L", crc32c(head + bytes(4) + chunks)) + chunks


def chunk(kind: int, body: bytes = b"") -> bytes:
    """Return one chunk (RFC 9260, 3.2); `body` has whole words."""
    return pack("!BBH", kind, 0, 4 + len(body)) + body


DEMANDING: Final = (
    chunk(4),  # an empty heartbeat
    chunk(7, pack("!L", 0)),  # a shutdown
    chunk(130, pack("!HHLLL", 13, 16, 1, 1, 1)),  # a reset of no existing stream (RFC 6525)
)
"""The shortest chunks that demand an answer each."""


def full_of(one: bytes) -> bytes:
    """Repeat a chunk until the datagram is full."""
    return one * (1140 // len(one))


# --- HTTP ---------------------------------------------------------------------------------


def http(path: str, *headers: tuple[str, str]) -> bytes:
    """Return a GET for a path; each header gets its own line, even with a repeated name."""
    lines = [f"GET {path} HTTP/1.1", "Host: 127.0.0.1"]
    lines += [f"{name}: {value}" for name, value in headers]
    return "\r\n".join([*lines, "", ""]).encode()


def post(path: str, body: bytes, *headers: str) -> bytes:
    """Return a POST of a JSON body."""
    lines = [f"POST {path} HTTP/1.1", "Host: 127.0.0.1", "Content-Type: application/json", *headers]
    return "\r\n".join([*lines, f"Content-Length: {len(body)}", "", ""]).encode() + body


# --- an offer ------------------------------------------------------------------------------


def wide(offer: str) -> str:
    """Return an offer with five video sections instead of one, each as long as it may be."""
    before, after = offer.split("m=video ", 1)
    picture, _, rest = after.partition("m=application")
    (mid,) = re.findall(r"^a=mid:(\S+)", picture, re.MULTILINE)
    mids = [f"{mid}{number}" for number in range(1, 5)]
    pictures = [picture.replace(f"a=mid:{mid}\r\n", f"a=mid:{one}\r\n") for one in (mid, *mids)]
    more = "".join(f"a=rtcp-fb:* x{number}\r\n" for number in range(_MORE_LINES))
    before = before.replace(f" {mid}", " ".join(["", mid, *mids]), 1)
    return before + "".join(f"m=video {one}{more}" for one in pictures) + "m=application" + rest
