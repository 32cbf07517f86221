"""RTP packets and sender reports as bytes (RFC 3550), with the few extensions we send. Pure.

Built by hand instead of with aiortc's classes, because it runs for each packet of each viewer.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Final, NamedTuple

TRANSPORT_SEQUENCE: Final = (
    "http://www.ietf.org/id/draft-holmer-rmcat-transport-wide-cc-extensions-01"
)
PLAYOUT_DELAY: Final = "http://www.webrtc.org/experiments/rtp-hdrext/playout-delay"
CAPTURE_TIME: Final = "http://www.webrtc.org/experiments/rtp-hdrext/abs-capture-time"

NTP_EPOCH_S: Final = 2_208_988_800
"""From 1900, where NTP begins (RFC 5905), to 1970."""

_ONE_BYTE_EXTENSIONS: Final = 0xBEDE
_SEQUENCE_ALONE: Final = struct.Struct("!HHBHB")
_HEADER: Final = struct.Struct("!BBHLL")
_VERSION: Final = 0x80
_HAS_EXTENSION: Final = 0x10
_SENDER_REPORT: Final = 200
_SOURCE_DESCRIPTION: Final = 202
_CNAME: Final = 1


@dataclass(frozen=True, slots=True)
class ExtensionIds:
    """The ids that the browser gave to the extensions; None for one that it does not support."""

    transport_sequence: int | None = None
    playout_delay: int | None = None
    capture_time: int | None = None


@dataclass(frozen=True, slots=True)
class PlayoutDelay:
    """The minimum and maximum playout delay of a picture, in steps of 10 ms (12 bits each)."""

    least_10ms: int
    most_10ms: int


class Packet(NamedTuple):
    """One packet without its header extensions, which differ each time that it is sent.

    `timestamp` is its RTP time. `playout_delay` and `captured_ntp` (64 bits) are values for its
    extensions.
    """

    payload_type: int
    sequence_number: int
    ssrc: int
    timestamp: int
    marker: bool
    payload: bytes
    playout_delay: PlayoutDelay | None = None
    captured_ntp: int | None = None
    head: bytes = b""
    """The payload's descriptor, kept apart from what all viewers share."""

    def to_bytes(self, extensions: bytes) -> bytes:
        """Return it as it is sent; `extensions` as `extension_block` makes them, or empty."""
        header = _HEADER.pack(
            _VERSION | (_HAS_EXTENSION if extensions else 0),
            self.payload_type | (0x80 if self.marker else 0),
            self.sequence_number,
            self.timestamp,
            self.ssrc,
        )
        return b"".join((header, extensions, self.head, self.payload))


def extension_block(
    ids: ExtensionIds,
    *,
    transport_sequence: int | None,
    playout_delay: PlayoutDelay | None = None,
    captured_ntp: int | None = None,
) -> bytes:
    """Return the header extensions (RFC 8285, one-byte form), empty if there are none."""
    number = ids.transport_sequence
    is_plain = playout_delay is None and captured_ntp is None
    if is_plain and number is not None and transport_sequence is not None:
        # The common case, in one step.
        return _SEQUENCE_ALONE.pack(_ONE_BYTE_EXTENSIONS, 1, number << 4 | 1, transport_sequence, 0)
    elements = b""
    if ids.transport_sequence is not None and transport_sequence is not None:
        elements = struct.pack("!BH", ids.transport_sequence << 4 | 1, transport_sequence)
    if ids.playout_delay is not None and playout_delay is not None:
        limits = playout_delay.least_10ms << 12 | playout_delay.most_10ms
        elements += bytes((ids.playout_delay << 4 | 2,)) + limits.to_bytes(3, "big")
    if ids.capture_time is not None and captured_ntp is not None:
        elements += bytes((ids.capture_time << 4 | 7,)) + captured_ntp.to_bytes(8, "big")
    if not elements:
        return b""
    words = (len(elements) + 3) // 4
    return struct.pack("!HH", _ONE_BYTE_EXTENSIONS, words) + elements.ljust(words * 4, b"\0")


def first_more_bytes(
    ids: ExtensionIds, playout_delay: PlayoutDelay | None, captured_ntp: int | None
) -> int:
    """Return by how much the extensions of a picture's first packet exceed those of the others."""
    number = None if ids.transport_sequence is None else 0
    more = extension_block(
        ids, transport_sequence=number, playout_delay=playout_delay, captured_ntp=captured_ntp
    )
    return len(more) - len(extension_block(ids, transport_sequence=number))


def ntp_time(unix_s: float) -> int:
    """Return Unix time as the 64 bits of NTP."""
    seconds, fraction = divmod(unix_s + NTP_EPOCH_S, 1)
    return int(seconds) << 32 | int(fraction * 2**32)


def sender_report(
    *, ssrc: int, ntp: int, timestamp: int, packets: int, octets: int, cname: str
) -> bytes:
    """Return a compound of sender report and CNAME (RFC 3550, 6.4.1 and 6.5.1)."""
    report = struct.pack(
        "!BBHLQLLL",
        _VERSION,
        _SENDER_REPORT,
        6,
        ssrc,
        ntp,
        timestamp,
        packets % 2**32,
        octets % 2**32,
    )
    item = bytes((_CNAME, len(cname))) + cname.encode()
    chunk = struct.pack("!L", ssrc) + item
    chunk += b"\0" * (4 - len(chunk) % 4)
    return report + struct.pack("!BBH", _VERSION | 1, _SOURCE_DESCRIPTION, len(chunk) // 4) + chunk
