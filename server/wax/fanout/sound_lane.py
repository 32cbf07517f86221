"""One viewer's sound: a short queue between the shared encoders and one sender."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.congestion.allocation import SoundForm
    from wax.encode.encoded import EncodedSound

_HELD_SAMPLES: Final = SAMPLE_RATE_HZ
"""One second: room for twice the largest pre-roll."""

_SENT: Final = 8
_REDUNDANT_SAMPLES: Final = 2**14 - 1
"""The largest age of repeated sound: 14 bits of time (RFC 2198, section 3)."""


class BoundedSoundLane:
    """Bounded queue of sound; when full it drops the oldest. Used only from the event loop.

    A change of form takes effect where units of both forms end together, so that every sample is
    sent once.
    """

    def __init__(self) -> None:
        self._queue: deque[tuple[SoundForm, EncodedSound]] = deque()
        self._held = 0
        self._sent: deque[tuple[SoundForm, EncodedSound]] = deque(maxlen=_SENT)
        self._on_news: Callable[[], None] = _nobody
        self._end_pts = 0
        self._form: SoundForm | None = None
        self._next: SoundForm | None = None
        self._change_pts = 0
        self.redundancy = 0
        """How many earlier packets each packet repeats, against loss (RFC 2198)."""
        self.takes_redundancy = True
        """Whether the browser takes them; Firefox does not."""
        self.dropped = 0

    @property
    def form(self) -> SoundForm | None:
        """The chosen form, None for no sound."""
        return self._form if self._next is None else self._next

    @property
    def forms(self) -> tuple[SoundForm, ...]:
        """The form being queued now, and the one that follows it."""
        return tuple(form for form in (self._form, self._next) if form is not None)

    def choose(self, form: SoundForm | None, change_pts: int = 0) -> None:
        """Choose a form, or None for no sound; it follows another one at `change_pts`."""
        self._next = None
        if form is None:
            self._form = None
            self._queue.clear()
            self._held = 0
        elif self._form is None:
            self._form = form
        elif form != self._form:
            self._next, self._change_pts = form, change_pts

    def listen(self, on_news: Callable[[], None]) -> None:
        """Set the callback for when there is something to take, replacing the previous one."""
        self._on_news = on_news

    def put(self, form: SoundForm, sound: EncodedSound) -> None:
        """Queue a packet if it is of the current form and was not queued before."""
        if self._next is not None and sound.pts >= self._change_pts and form in self.forms:
            self._form, self._next = self._next, None
        if form != self._form or sound.pts < self._end_pts:
            return
        self._end_pts = sound.pts + sound.duration_samples
        self._queue.append((form, sound))
        self._held += sound.duration_samples
        while self._held > _HELD_SAMPLES:
            self._held -= self._queue.popleft()[1].duration_samples
            self.dropped += 1
        self._on_news()

    def take(self) -> EncodedSound | None:
        """Return the next packet to send, None if there is none."""
        if not self._queue:
            return None
        form, sound = self._queue.popleft()
        self._held -= sound.duration_samples
        self._sent.append((form, sound))
        return sound

    def offered(self, *, redundancy: bool) -> None:
        self.takes_redundancy = redundancy

    def earlier(self, sound: EncodedSound) -> tuple[EncodedSound, ...]:
        """Return up to `redundancy` packets to repeat with this one, the oldest first.

        `sound` was returned by `take`. They have its form, and each ends where the next begins.
        """
        if self.redundancy == 0:
            return ()
        found: list[EncodedSound] = []
        later: EncodedSound | None = None
        wanted: SoundForm | None = None
        for form, earlier in reversed(self._sent):
            if later is None:
                later, wanted = (sound, form) if earlier is sound else (None, None)
                continue
            follows = form == wanted and earlier.pts + earlier.duration_samples == later.pts
            is_near = sound.pts - earlier.pts <= _REDUNDANT_SAMPLES
            if len(found) >= self.redundancy or not follows or not is_near:
                break
            found.append(earlier)
            later = earlier
        return tuple(reversed(found))


def _nobody() -> None: ...
