"""One viewer's lane of pictures: a short queue between the shared encoders and one sender.

A slow viewer affects only their own lane. Drops are counted. After dropping a picture that others
depend on, the lane waits for a keyframe, which it never requests itself.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.encode.encoded import EncodedPicture

_PICTURES: Final = 16
_BASE_PICTURES: Final = 4
"""When more pictures of layer 0 than this are queued, half a second or more, they are stale."""
_TOP: Final = 2
"""The highest temporal layer of an encoder."""


class VideoLane:
    """Bounded queue of pictures of one rendition; `rendition` None means no picture.

    A change of rendition takes effect at the new one's next keyframe; until then the old one
    continues, unless `give_up` ends it. Used only from the event loop.
    """

    def __init__(self) -> None:
        self._queue: deque[EncodedPicture] = deque()
        self._on_news: Callable[[], None] = _nobody
        self._rendition: str | None = None
        self._current: str | None = None
        self._cut_layer: int | None = 0
        self._newest_pts = -1
        self.top_layer = _TOP
        """Pictures above this temporal layer are dropped."""
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
        """Stop the current rendition and send nothing until the chosen one's next keyframe."""
        self._current = None
        self._cut_layer = 0
        self.dropped += len(self._queue)
        self._queue.clear()

    @property
    def is_cut(self) -> bool:
        """Whether only a keyframe can make pictures decodable again."""
        return self._rendition is not None and self._cut_layer == 0

    @property
    def is_waiting(self) -> bool:
        """Whether the previous rendition still continues because the chosen one has not begun."""
        return self._rendition is not None and self._current not in (None, self._rendition)

    def takes(self, rendition: str) -> bool:
        """Whether this lane wants pictures of this rendition now."""
        return rendition in (self._rendition, self._current)

    def set_listener(self, on_news: Callable[[], None]) -> None:
        """Set the callback for new pictures, replacing the previous callback."""
        self._on_news = on_news

    @property
    def is_empty(self) -> bool:
        return not self._queue

    def put(self, picture: EncodedPicture) -> None:
        """Queue a picture if it is wanted and decodable."""
        if picture.rendition != self._current:
            if picture.rendition != self._rendition or not picture.keyframe:
                return
            if picture.pts < self._newest_pts:
                return  # its encoder was slower: never send a picture after a newer one
            self._current = picture.rendition
        if picture.keyframe:
            # Queued pictures are older, and nothing new depends on them.
            self.dropped += len(self._queue)
            self._queue.clear()
        if not self._decodable(picture):
            self.dropped += 1
            return
        if picture.layer > self.top_layer:
            self._drop(picture)
            return
        if picture.pts == self._newest_pts:  # the same moment in another rendition
            picture = replace(picture, pts=picture.pts + 1)
        self._newest_pts = picture.pts
        self._queue.append(picture)
        base = sum(one.layer == 0 for one in self._queue)
        if base > _BASE_PICTURES or len(self._queue) > _PICTURES:
            self._shed()
        if self._queue:
            self._on_news()

    def pop_next(self) -> EncodedPicture | None:
        """Return the picture to send now, skipping all droppable ones but the newest.

        Pictures that others depend on are sent in order. Return None if nothing is queued.
        """
        if len(self._queue) > 1:
            self._thin()
        return self._queue.popleft() if self._queue else None

    def _thin(self) -> None:
        newest = self._queue.pop()
        # In each group of four, the second layer-2 picture depends on the layer-1 picture before.
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
        """After a drop in layer k, the layers above k (all, for k = 0) wait for the next of k.

        A picture of layer k depends on lower layers only through the newest of each, so the next
        one of layer k restores decoding; for layer 0 only a keyframe does.
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
        """Drop the whole queue; the next keyframe restores decoding."""
        for picture in self._queue:
            self._drop(picture)
        self._queue.clear()


def _nobody() -> None: ...
