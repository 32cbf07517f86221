"""Detects datagrams that cannot be genuine DTLS or SRTP, whoever sent them. Pure.

Anybody can forge a viewer's address and port. Implausible datagrams are dropped before the
libraries see them, and so is the one DTLS message that is believed without a key: a plaintext
alert.
"""

from __future__ import annotations

from typing import Final

MAX_BYTES: Final = 1500
"""The most that an Ethernet frame carries and that pylibsrtp has room for."""

_LEAST_RTP_BYTES: Final = 22
"""A header (RFC 3550, 5.1) and the tag of the browsers' SRTP profiles (RFC 5764, 4.1.2)."""
_LEAST_RTCP_BYTES: Final = 20
"""A header with its SSRC, the index, and the shortest tag (RFC 3711, 3.4; RFC 7714)."""
_RTCP: Final = range(192, 224)
"""Packet types that mean RTCP on a port shared with RTP (RFC 5761, 4)."""
_RECORD_BYTES: Final = 13
_ALERT: Final = 21
_HANDSHAKE: Final = 22
_MESSAGE_BYTES: Final = 12
"""The header of a handshake message, or of each of its fragments (RFC 6347, 4.2.2)."""
_CERTIFICATE: Final = 11
MAX_CERTIFICATE_BYTES: Final = 2048
"""Browsers send a self-signed certificate of 300 to 800 bytes; OpenSSL would accept 100,000, and
verify each signature of that chain in one go."""
_CONTENT: Final = range(20, 27)
_DTLS_13: Final = range(32, 64)
"""Records with the short header are encrypted (RFC 9147, 4.1)."""


def is_plausible(data: bytes) -> bool:
    """Whether a browser may have sent this, judged without a key (RFC 7983)."""
    if not 2 <= len(data) <= MAX_BYTES:
        return False
    first = data[0]
    if 128 <= first < 192:
        least = _LEAST_RTCP_BYTES if data[1] in _RTCP else _LEAST_RTP_BYTES
        return len(data) >= least
    return first in _DTLS_13 or (first in _CONTENT and _has_whole_records(data))


def has_long_certificate(data: bytes) -> bool:
    """Whether a plausible datagram has a fragment of a certificate longer than any browser's."""
    at = 0
    while at < len(data) and data[at] in _CONTENT:
        begin, epoch = at + _RECORD_BYTES, data[at + 3] << 8 | data[at + 4]
        end = begin + (data[at + 11] << 8 | data[at + 12])
        if epoch == 0 and data[at] == _HANDSHAKE and _announces_long(data[begin:end]):
            return True
        at = end
    return False


def source(data: bytes) -> bytes | None:
    """Return the plaintext SSRC of a plausible datagram, None for DTLS."""
    if not 128 <= data[0] < 192:
        return None
    return rtcp_source(data) if data[1] in _RTCP else rtp_source(data)


def rtp_source(data: bytes) -> bytes:
    """Return the SSRC of an RTP packet (RFC 3550, 5.1)."""
    return data[8:12]


def rtcp_source(data: bytes) -> bytes:
    """Return the SSRC of an RTCP packet's sender (RFC 3550, 6.4)."""
    return data[4:8]


def _has_whole_records(data: bytes) -> bool:
    """Whether these are whole DTLS records (RFC 6347, 4.1), and none is a plaintext alert.

    Without alerts a failed handshake ends by its timeout instead of at once.
    """
    at = 0
    while at < len(data):
        if data[at] in _DTLS_13:
            return True
        if at + _RECORD_BYTES > len(data) or data[at + 1] != 0xFE or data[at] not in _CONTENT:
            return False
        epoch = data[at + 3] << 8 | data[at + 4]
        length = data[at + 11] << 8 | data[at + 12]
        if length == 0 or (epoch == 0 and data[at] == _ALERT):
            return False
        at += _RECORD_BYTES + length
    return at == len(data)


def _announces_long(messages: bytes) -> bool:
    at = 0
    while at + _MESSAGE_BYTES <= len(messages):
        length = int.from_bytes(messages[at + 1 : at + 4])
        if messages[at] == _CERTIFICATE and length > MAX_CERTIFICATE_BYTES:
            return True
        at += _MESSAGE_BYTES + int.from_bytes(messages[at + 9 : at + 12])
    return False
