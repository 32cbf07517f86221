"""One viewer's lane of pictures: a short queue between the shared encoders and one sender.

A slow viewer changes their own lane only. What is dropped is counted; only what nothing depends on
may be dropped, otherwise the lane waits for a keyframe, and it never asks for one itself.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from av.packet import Packet

from wax.encode.encoded import VIDEO_TIME_BASE

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.encode.encoded import EncodedPicture

_PICTURES: Final = 16
_BASE_PICTURES: Final = 4
"""Of layer 0; where so many wait, half a second and more, what waits is stale."""
_TOP: Final = 2
"""The highest temporal layer that an encoder makes."""


class VideoLane:
    """Bounded queue of pictures of one rendition; `rendition` None means not wanted.

    A change of rendition takes effect at the next keyframe of the new one; until then the
    old one goes on, unless it is given up. Used from the event loop only.
    """

    def __init__(self) -> None:
        self._queue: deque[EncodedPicture] = deque()
        self._on_news: Callable[[], None] = _nobody
        self._rendition: str | None = None
        self._current: str | None = None
        self._cut_layer: int | None = 0
        self._newest_pts = -1
        self.top_layer = _TOP
        """Pictures above this temporal layer are left out."""
        self.dropped = 0

    @property
    def rendition(self) -> str | None:
        return self._rendition

    def choose(self, rendition: str | None) -> None:
        """Choose a rendition by name, or None for no picture at all."""
        self._rendition = rendition
        if rendition is None:
            self.give_up()

    def give_up(self) -> None:
        """Send no more of what is sent now: nothing until the next keyframe of what is chosen."""
        self._current = None
        self._cut_layer = 0
        self.dropped += len(self._queue)
        self._queue.clear()

    @property
    def is_cut(self) -> bool:
        """Whether pictures are wanted that only a keyframe makes decodable again."""
        return self._rendition is not None and self._cut_layer == 0

    @property
    def is_waiting(self) -> bool:
        """Whether what is chosen has not begun, while what went before goes on."""
        return self._rendition is not None and self._current not in (None, self._rendition)

    def takes(self, rendition: str) -> bool:
        """Tell whether pictures of this rendition are wanted here now."""
        return rendition in (self._rendition, self._current)

    def listen(self, on_news: Callable[[], None]) -> None:
        """Call back whenever there is something to take; replaces whoever listened before."""
        self._on_news = on_news

    def put(self, picture: EncodedPicture) -> None:
        """Queue a picture, if it is wanted here and can be decoded there."""
        if picture.rendition != self._current:
            if picture.rendition != self._rendition or not picture.keyframe:
                return
            if _pts(picture) < self._newest_pts:
                return  # its encoder was slower: no picture is sent after a newer one
            self._current = picture.rendition
        if picture.keyframe:
            # What waits is older, and nothing that comes now depends on it.
            self.dropped += len(self._queue)
            self._queue.clear()
        if not self._decodable(picture):
            self.dropped += 1
            return
        if picture.layer > self.top_layer:
            self._drop(picture)
            return
        if _pts(picture) == self._newest_pts:
            picture = _one_tick_later(picture)  # the same moment in another rendition
        self._newest_pts = _pts(picture)
        self._queue.append(picture)
        base = sum(one.layer == 0 for one in self._queue)
        if base > _BASE_PICTURES or len(self._queue) > _PICTURES:
            self._shed()
        if self._queue:
            self._on_news()

    def take(self) -> EncodedPicture | None:
        """Return the picture to send now: of those that wait, the droppable ones but the newest go.

        What other pictures depend on is sent in its order. None where nothing waits.
        """
        if len(self._queue) > 1:
            self._thin()
        return self._queue.popleft() if self._queue else None

    def _thin(self) -> None:
        newest = self._queue.pop()
        # The second picture of layer 2 in each four is made of the layer 1 before it.
        needs_upper = newest.layer == _TOP and not newest.sync
        upper = next((p for p in reversed(self._queue) if p.layer < _TOP), None)
        keep: deque[EncodedPicture] = deque()
        for picture in (*self._queue, newest):
            is_base = needs_upper and picture is upper
            if picture.layer == 0 or picture is newest or is_base:
                keep.append(picture)
                if picture.layer == self._cut_layer:
                    self._cut_layer = None
            else:
                self._drop(picture)
        self._queue = keep

    def _decodable(self, picture: EncodedPicture) -> bool:
        """After a drop in layer k, layers above k (all, for k = 0) wait for the next of k.

        A picture of layer k depends on lower layers only through the newest of each, so the
        next one of layer k that arrives heals the cut; layer 0 heals by a keyframe alone.
        """
        if picture.keyframe or self._cut_layer is None:
            self._cut_layer = None
            return True
        if self._cut_layer == 0:
            return False
        if picture.layer > self._cut_layer:
            return picture.sync
        if picture.layer == self._cut_layer:
            self._cut_layer = None
        return True

    def _drop(self, picture: EncodedPicture) -> None:
        self.dropped += 1
        if not picture.droppable and (self._cut_layer is None or picture.layer < self._cut_layer):
            self._cut_layer = picture.layer

    def _shed(self) -> None:
        """Drop all that waits; the next keyframe heals it."""
        for picture in self._queue:
            self._drop(picture)
        self._queue.clear()


def _nobody() -> None: ...


def _pts(picture: EncodedPicture) -> int:
    return picture.packet.pts or 0


def _one_tick_later(picture: EncodedPicture) -> EncodedPicture:
    """Return the picture with an RTP time of its own; the packet is shared with other lanes."""
    packet: Packet[Any] = Packet(bytes(picture.packet))
    packet.pts = _pts(picture) + 1
    packet.time_base = VIDEO_TIME_BASE
    return replace(picture, packet=packet)
