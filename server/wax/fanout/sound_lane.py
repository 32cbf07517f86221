"""One viewer's sound: a short queue between the shared encoders and one sender."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.congestion.allocation import SoundEncoding
    from wax.encode.encoded import EncodedSound

_HELD_SAMPLES: Final = SAMPLE_RATE_HZ
"""One second: room for twice the largest pre-roll."""

_SENT: Final = 8
_REDUNDANT_SAMPLES: Final = 2**14 - 1
"""The largest age of repeated sound: a 14-bit timestamp offset (RFC 2198, section 3)."""


class BoundedSoundLane:
    """Bounded queue of sound; when full it drops the oldest. Used only from the event loop.

    A change of encoding takes effect at a common unit boundary, so that every sample is sent once.
    """

    def __init__(self) -> None:
        self._queue: deque[tuple[SoundEncoding, EncodedSound]] = deque()
        self._held = 0
        self._sent: deque[tuple[SoundEncoding, EncodedSound]] = deque(maxlen=_SENT)
        self._on_news: Callable[[], None] = _nobody
        self._end_pts = 0
        self._encoding: SoundEncoding | None = None
        self._next: SoundEncoding | None = None
        self._change_pts = 0
        self.redundancy = 0
        """How many earlier packets each packet repeats to repair loss (RFC 2198)."""
        self.takes_redundancy = True
        """Whether the browser accepts repeated packets; Firefox does not."""
        self.dropped = 0

    @property
    def encoding(self) -> SoundEncoding | None:
        """The chosen encoding, None for no sound."""
        return self._encoding if self._next is None else self._next

    @property
    def encodings(self) -> tuple[SoundEncoding, ...]:
        """The encoding being queued now, and the next one."""
        return tuple(one for one in (self._encoding, self._next) if one is not None)

    def choose(self, encoding: SoundEncoding | None, change_pts: int = 0) -> None:
        """Choose an encoding, or None for no sound; it replaces the current one at `change_pts`."""
        self._next = None
        if encoding is None:
            self._encoding = None
            self._queue.clear()
            self._held = 0
        elif self._encoding is None:
            self._encoding = encoding
        elif encoding != self._encoding:
            self._next, self._change_pts = encoding, change_pts

    def set_listener(self, on_news: Callable[[], None]) -> None:
        """Set the callback for new packets, replacing the previous callback."""
        self._on_news = on_news

    def put(self, encoding: SoundEncoding, sound: EncodedSound) -> None:
        """Queue a packet if it has the current encoding and was not queued before."""
        if self._next is not None and sound.pts >= self._change_pts and encoding in self.encodings:
            self._encoding, self._next = self._next, None
        if encoding != self._encoding or sound.pts < self._end_pts:
            return
        self._end_pts = sound.pts + sound.duration_samples
        self._queue.append((encoding, sound))
        self._held += sound.duration_samples
        while self._held > _HELD_SAMPLES:
            self._held -= self._queue.popleft()[1].duration_samples
            self.dropped += 1
        self._on_news()

    def pop_next(self) -> EncodedSound | None:
        """Return the next packet to send, None if there is none."""
        if not self._queue:
            return None
        encoding, sound = self._queue.popleft()
        self._held -= sound.duration_samples
        self._sent.append((encoding, sound))
        return sound

    def set_redundancy(self, *, is_accepted: bool) -> None:
        self.takes_redundancy = is_accepted

    def packets_to_repeat(self, sound: EncodedSound) -> tuple[EncodedSound, ...]:
        """Return up to `redundancy` packets to repeat with this one, the oldest first.

        `sound` was returned by `pop_next`. The packets are contiguous and all have its encoding.
        """
        if self.redundancy == 0:
            return ()
        found: list[EncodedSound] = []
        later: EncodedSound | None = None
        wanted: SoundEncoding | None = None
        for encoding, earlier in reversed(self._sent):
            if later is None:
                later, wanted = (sound, encoding) if earlier is sound else (None, None)
                continue
            follows = encoding == wanted and earlier.pts + earlier.duration_samples == later.pts
            is_near = sound.pts - earlier.pts <= _REDUNDANT_SAMPLES
            if len(found) >= self.redundancy or not follows or not is_near:
                break
            found.append(earlier)
            later = earlier
        return tuple(reversed(found))


def _nobody() -> None: ...
