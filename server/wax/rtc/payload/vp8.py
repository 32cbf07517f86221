"""VP8 pictures as RTP payloads (RFC 7741), numbered for one viewer. Pure.

The browser decodes by these numbers. libwebrtc assumes that a picture of layer 0 depends on the one
whose TL0PICIDX is one less; a picture with the layer sync bit only on the layer 0 with the same
TL0PICIDX; and any other picture on the newest one of every layer up to its own. It holds the last
kind back while a PictureID since its layer 0 is missing (one after the first that arrived). So
PictureIDs count only pictures that were *sent*: intentional drops leave no gap, losses do, and a
picture held back for a loss delays no later one.
"""

from __future__ import annotations

from typing import Final

from wax.rtc.payload.split import MIN_PACKET_BYTES, Payload, split_evenly

DESCRIPTOR_BYTES: Final = 6

_EXTENDED: Final = 0x80
_NON_REFERENCE: Final = 0x20
_START: Final = 0x10
_HAS_PICTURE_ID_TL0PICIDX_TID: Final = 0x80 | 0x40 | 0x20
_LONG: Final = 0x8000
_SYNC: Final = 0x20


class Vp8Packetizer:
    """Packetises the pictures sent to one viewer; each RTP stream needs a new one."""

    def __init__(self, *, picture_id: int, tl0_picidx: int) -> None:
        self._picture_id = picture_id & 0x7FFF
        self._tl0_picidx = (tl0_picidx - 1) & 0xFF
        self._top_since_base = 0

    def packets(
        self,
        data: bytes,
        *,
        layer: int,
        sync: bool,
        droppable: bool,
        keyframe: bool,
        max_bytes: int,
        first_less: int = 0,
    ) -> list[Payload]:
        """Return one picture's payloads, each of at most `max_bytes` with its descriptor.

        The first is shorter by `first_less` (`split_evenly`).

        `layer` is the temporal layer, 0 to 3. `sync` says that the picture depends on the newest of
        layer 0 only, `droppable` that no other depends on it. Call it for each picture that is
        sent, in order, and only if every picture that it depends on was sent: the numbers hide what
        was left out. A picture may depend on pictures before the newest of layer 0 only through
        that one. Raises `ValueError` for a keyframe above layer 0, which browsers throw away, and
        for `max_bytes` below 32.
        """
        if keyframe and layer:
            raise ValueError("a keyframe belongs to layer 0")
        if max_bytes < MIN_PACKET_BYTES:
            raise ValueError(f"a payload needs room for {MIN_PACKET_BYTES} bytes")
        pieces = split_evenly(data, max_bytes - DESCRIPTOR_BYTES, first_less)
        if not pieces:
            return []
        number = self._numbers(self._numbered_layer(layer, sync), sync)
        first = _EXTENDED | (_NON_REFERENCE if droppable else 0)
        head = bytes((first,)) + number
        return [
            (bytes((first | _START,)) + number, pieces[0]),
            *((head, piece) for piece in pieces[1:]),
        ]

    def _numbered_layer(self, layer: int, sync: bool) -> int:
        """Return the layer that the picture is numbered in, and remember it.

        If nothing of its own layer was sent since layer 0, a picture is numbered in the highest
        layer that was, the highest it can depend on. Otherwise the browser would search for its own
        layer further back, past any loss since, and hold back picture after picture.
        """
        if layer == 0:
            self._tl0_picidx = (self._tl0_picidx + 1) & 0xFF
            self._top_since_base = 0
        elif not sync and 0 < self._top_since_base < layer:
            return self._top_since_base
        self._top_since_base = max(self._top_since_base, layer)
        return layer

    def _numbers(self, tid: int, sync: bool) -> bytes:
        long_id = _LONG | self._picture_id
        self._picture_id = (self._picture_id + 1) & 0x7FFF
        return bytes(
            (
                _HAS_PICTURE_ID_TL0PICIDX_TID,
                long_id >> 8,
                long_id & 0xFF,
                self._tl0_picidx,
                tid << 6 | (_SYNC if sync else 0),
            )
        )
