"""Reduces an offer to the lines on which our answer depends. Pure.

A browser writes up to 104 lines for a picture, most of them about codecs and extensions that this
server lacks. aiortc reads each line several times, looks every codec up in a list, and keeps it all
as long as the peer lives. It gets at most 40 lines per picture, whatever a stranger writes: no line
twice, and of an attribute that may be given only once, the last, as in aiortc.
"""

from __future__ import annotations

import re
from itertools import islice
from typing import TYPE_CHECKING, Final

from aiortc.codecs import HEADER_EXTENSIONS

from wax.errors import SignallingError
from wax.rtc.rtp import PLAYOUT_DELAY, TRANSPORT_SEQUENCE

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

OURS: Final = frozenset({"opus", "pcmu", "vp8", "h264"})
"""All codecs that a server may have."""
_H264: Final = "h264"
_REPAIRS: Final = ("rtx", "red")
_MOST_CODECS: Final = 4
"""Per section, without their retransmissions; browsers offer three of ours."""
_MOST_OFFERED: Final = 128
"""Per section: a payload type has 7 bits (RFC 3550, 5.1)."""
_MOST_FINGERPRINTS: Final = 4
"""Per section, and at session level; browsers write one, and a handshake computes each."""
_MOST_CHARS: Final = 512
"""Per kept line; browsers write 130."""
_BEFORE_TYPES: Final = 3
"""The fields of an m= line before its payload types."""

_FEEDBACK: Final = frozenset({"nack", "nack pli", "goog-remb", "transport-cc"})
_EXTENSIONS: Final = frozenset(
    {one.uri for of_kind in HEADER_EXTENSIONS.values() for one in of_kind}
    | {TRANSPORT_SEQUENCE, PLAYOUT_DELAY}
)
_ALONE: Final = (
    *("group", "msid-semantic", "ice-lite", "ice-options", "ice-pwd", "ice-ufrag", "setup"),
    *("max-message-size", "mid", "msid", "rtcp", "rtcp-mux", "sctp-port", "sctpmap"),
)
_DIRECTIONS: Final = ("sendrecv", "sendonly", "recvonly", "inactive")
_ONCE: Final = {one: one for one in _ALONE} | dict.fromkeys(_DIRECTIONS, "direction")
"""Attributes of which only the last counts, each with the property that it sets."""
_NUMBER: Final = re.compile(r"[0-9]{1,10}")


def essential(lines: Iterable[str], codecs: Collection[str]) -> list[str]:
    """Return the lines that matter, section by section; raises `SignallingError`.

    `codecs` are those of ours that are sent; a section without any of them keeps our other ones.
    """
    kept: list[str] = []
    section = _Section("")
    for line in lines:
        if line.startswith("m="):
            kept += section.essential(codecs)
            section = _Section(line)
        else:
            section.add(line)
    return kept + section.essential(codecs)


class _Section:
    """A media section, or the session level if the first line is empty."""

    def __init__(self, first: str) -> None:
        self._first = first
        self._lines: dict[str, str] = {}
        """Keyed by the property that may be given only once."""
        self._names: dict[str, str] = {}
        """Names of all codecs, keyed by payload type like the next two."""
        self._codecs: dict[str, str] = {}
        self._formats: dict[str, str] = {}
        self._feedback: dict[str, str] = {}
        """Payload types, keyed by the whole line."""
        self._several: dict[str, list[str]] = {"fingerprint": [], "candidate": []}

    def add(self, line: str) -> None:
        """Store a line if it may matter."""
        if not line.startswith("a="):
            if line.startswith(("v=", "o=", "s=", "t=", "c=")):
                self._lines[line[:2]] = line
            return
        attribute, _, value = line[2:].partition(":")
        if attribute in _ONCE:
            self._lines[_ONCE[attribute]] = line
        elif attribute in self._several:
            self._several[attribute].append(line)
        elif attribute == "rtpmap":
            self._add_codec(line, *value.split(" ", 1))
        elif attribute == "fmtp":
            self._formats[value.partition(" ")[0]] = line
        elif attribute == "rtcp-fb" and value.partition(" ")[2] in _FEEDBACK:
            self._feedback[line] = value.partition(" ")[0]
        elif attribute == "extmap" and (uri := value.rpartition(" ")[2]) in _EXTENSIONS:
            self._lines[uri] = line

    def _add_codec(self, line: str, payload_type: str, name: str = "") -> None:
        number = str(whole_number(payload_type, "payload type"))
        if number in self._names:
            raise SignallingError(f"the offer has payload type {number} twice")
        self._names[number] = name.partition("/")[0].lower()
        self._codecs[number] = line
        if len(self._names) > _MOST_OFFERED:
            raise SignallingError(f"a section of the offer has more than {_MOST_OFFERED} codecs")

    def essential(self, codecs: Collection[str]) -> list[str]:
        """Return the stored lines that matter, the m= line first."""
        fingerprints, candidates = self._several.values()
        if len(fingerprints) > _MOST_FINGERPRINTS:
            raise SignallingError(f"the offer has more than {_MOST_FINGERPRINTS} fingerprints")
        ours = self._ours(codecs) or self._ours(OURS)
        ours |= self._repairs(ours)
        kept = [*self._lines.values(), *fingerprints, *candidates]
        kept += [line for number, line in self._codecs.items() if number in ours]
        kept += [line for number, line in self._formats.items() if number in ours]
        kept += [line for line, number in self._feedback.items() if number in {*ours, "*"}]
        if any(len(line) > _MOST_CHARS for line in kept):
            raise SignallingError(f"the offer has a line of more than {_MOST_CHARS} characters")
        return [self._first_line(ours), *kept] if self._first else kept

    def _ours(self, codecs: Collection[str]) -> set[str]:
        """Return the first payload types of these codecs."""
        found = (number for number, name in self._names.items() if name in codecs)
        return set(islice((one for one in found if self._is_sent(one)), _MOST_CODECS))

    def _is_sent(self, number: str) -> bool:
        """Whether we send this format: of H.264, only baseline in packetization mode 1."""
        if self._names[number] != _H264:
            return True
        form = self._formats.get(number, "").lower()
        return "packetization-mode=1" in form and ("-level-id=" in form) <= ("-id=42" in form)

    def _repairs(self, ours: set[str]) -> set[str]:
        """Return our codecs' retransmissions (RFC 4588) and redundant sound (RFC 2198)."""
        found = (number for number, name in self._names.items() if name in _REPAIRS)
        repairs = (one for one in found if _repaired(self._formats.get(one, "")) in ours)
        return set(islice(repairs, 2 * _MOST_CODECS))

    def _first_line(self, ours: set[str]) -> str:
        """Return the m= line without the payload types of other codecs."""
        start = self._first.split(" ")
        return " ".join(
            start[:_BEFORE_TYPES]
            + [one for one in start[_BEFORE_TYPES:] if one in ours or one not in self._names]
        )


def whole_number(text: str, what: str) -> int:
    """Parse a number that every parser reads alike; raises `SignallingError`."""
    if _NUMBER.fullmatch(text) is None:
        raise SignallingError(f"the offer has a {what} that is not a number")
    return int(text)


def _repaired(form: str) -> str:
    """Return the payload type that this format repairs: 96 in `97 apt=96`, 111 in `63 111/111`."""
    what = form.rpartition(" ")[2]
    return what.removeprefix("apt=").partition("/")[0]
