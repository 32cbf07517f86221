"""H.264's parameter sets, without which a decoder cannot start at a keyframe. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

_START: Final = b"\x00\x00\x01"
_TYPE: Final = 0x1F
_IDR: Final = 5
_SPS: Final = 7
_PPS: Final = 8


class ParameterSets:
    """Stores the newest parameter sets and prepends them to keyframes that lack them.

    Some hardware outputs them once, with its first picture, but later viewers need them, too. They
    are read from `extradata` and from each keyframe.
    """

    def __init__(self, extradata: bytes = b"") -> None:
        self._kept: dict[int, bytes] = {}
        self._store(extradata)

    def prepend_to(self, keyframe: bytes) -> bytes:
        """Return the keyframe with parameter sets; unchanged if none are known."""
        if {_SPS, _PPS} <= self._store(keyframe) or not {_SPS, _PPS} <= self._kept.keys():
            return keyframe
        kept = (b"\x00" + _START + self._kept[kind] for kind in (_SPS, _PPS))
        return b"".join(kept) + keyframe

    def _store(self, data: bytes) -> set[int]:
        found = {unit[0] & _TYPE: unit for unit in units(data) if unit[0] & _TYPE in (_SPS, _PPS)}
        self._kept |= found
        return set(found)


def can_start_decoder(data: bytes) -> bool:
    """Return whether a decoder can start with this picture."""
    return {_SPS, _PPS, _IDR} <= {unit[0] & _TYPE for unit in units(data)}


def profile(data: bytes) -> int | None:
    """Return the profile that the stream declares (66 is baseline), None if it declares none."""
    sets = (unit for unit in units(data) if unit[0] & _TYPE == _SPS and len(unit) > 1)
    first = next(sets, None)
    return None if first is None else first[1]


def units(data: bytes) -> Iterator[bytes]:
    """Split at the start codes (H.264, annex B), without trailing zeros or leading bytes."""
    at = data.find(_START)
    while at >= 0:
        following = data.find(_START, at + 3)
        unit = data[at + 3 : following if following >= 0 else len(data)].rstrip(b"\x00")
        if unit:
            yield unit
        at = following
