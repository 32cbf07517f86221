"""One viewer's lane: a short queue between the shared encoders and his own track.

A slow viewer changes his own lane only. What is dropped is counted; in encoded video only what
nothing depends on may be dropped, otherwise the lane waits for a keyframe, and it never asks
for one itself.
"""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.media.encoded import EncodedPicture

_PICTURES: Final = 8


class VideoLane:
    """Bounded queue of pictures of one rendition; `rendition` None means not wanted.

    A change of rendition takes effect at the next keyframe of the new one; until then the
    old one goes on. Used from the event loop only.
    """

    def __init__(self) -> None:
        self._queue: deque[EncodedPicture] = deque()
        self._ready = asyncio.Event()
        self._rendition: str | None = None
        self._current: str | None = None
        self._cut_layer: int | None = 0
        self.dropped = 0

    @property
    def rendition(self) -> str | None:
        return self._rendition

    def choose(self, rendition: str | None) -> None:
        """Choose a rendition by name, or None for no picture at all."""
        self._rendition = rendition
        if rendition is None:
            self._current = None
            self._queue.clear()
            self._ready.clear()

    def takes(self, rendition: str) -> bool:
        """Tell whether pictures of this rendition are wanted here now."""
        return rendition in (self._rendition, self._current)

    def put(self, picture: EncodedPicture) -> None:
        """Queue a picture, if it is wanted here and can be decoded there."""
        if picture.rendition != self._current:
            if picture.rendition != self._rendition or not picture.keyframe:
                return
            self._current = picture.rendition
        if not self._decodable(picture):
            self.dropped += 1
            return
        self._queue.append(picture)
        if len(self._queue) > _PICTURES:
            self._shed()
        self._ready.set()

    async def get(self) -> EncodedPicture:
        """Wait for the next picture to send."""
        while not self._queue:
            self._ready.clear()
            await self._ready.wait()
        return self._queue.popleft()

    def _decodable(self, picture: EncodedPicture) -> bool:
        """After a drop in layer k, layers above k (all, for k = 0) wait for the next of k.

        A picture of layer k depends on lower layers only through the newest of each, so the
        next one of layer k that arrives heals the cut; layer 0 heals by a keyframe alone.
        """
        if picture.keyframe or self._cut_layer is None:
            self._cut_layer = None
            return True
        if self._cut_layer == 0 or picture.layer > self._cut_layer:
            return False
        if picture.layer == self._cut_layer:
            self._cut_layer = None
        return True

    def _shed(self) -> None:
        """Make room: the upper layers go first; if only layer 0 is left, all but a keyframe."""
        top = max(picture.layer for picture in self._queue)
        keep = deque(p for p in self._queue if p.keyframe or p.layer < top) if top else deque()
        self.dropped += len(self._queue) - len(keep)
        self._queue = keep
        if self._cut_layer is None or top < self._cut_layer:
            self._cut_layer = top
