"""Encodes one rendition in a thread, always the newest picture, while anybody watches."""

from __future__ import annotations

import math
import threading
from typing import TYPE_CHECKING, Final

import structlog

from wax.rate_limits import TokenBucket

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.newest_slot import NewestSlot
    from wax.capture.source import Picture
    from wax.clock import Clock
    from wax.config.video import RenditionSettings
    from wax.encode.encoded import EncodedPicture
    from wax.encode.video_encoder import PictureEncoder

_LOG = structlog.get_logger(__name__)

_KEYFRAME_SPACING_S: Final = 0.3
"""Keyframe requests are coalesced to this interval, in case many viewers lose packets."""
_KEYFRAMES_HZ: Final = 1.0
_KEYFRAMES_BURST: Final = 6.0
"""Token bucket of requested keyframes, because all viewers receive each one and some viewer always
asks. It also holds for the first picture after a pause, since viewers who come and go pause a
rendition as they like. An operator's request is never delayed: nobody can drive without a picture.
"""

_POLL_S: Final = 0.5

_KEEP_S: Final = 5.0
"""How long a paused rendition keeps its encoder. FFmpeg holds Python's lock to open one: 13 ms
for 640×480, 31 ms for 1280×720 on a slow machine, and viewers come and go as they like."""

_LOAD_WEIGHT: Final = 0.05
"""The weight of one picture in the mean encoding time, and in the mean frame interval."""


class Rendition:
    """Encodes one size for everybody; `deliver` is called from the thread with each packet."""

    def __init__(
        self,
        *,
        settings: RenditionSettings,
        keyframe_interval_s: float,
        make_encoder: Callable[[], PictureEncoder],
        slot: NewestSlot[Picture],
        clock: Clock,
        deliver: Callable[[EncodedPicture], None],
    ) -> None:
        self.settings = settings
        self._keyframe_interval_s = keyframe_interval_s
        self._make_encoder = make_encoder
        self._slot = slot
        self._clock = clock
        self._deliver = deliver
        self._wanted = threading.Event()
        self._keyframe = threading.Event()
        self._is_urgent = False
        self._keyframes = TokenBucket(_KEYFRAMES_HZ, _KEYFRAMES_BURST)
        self._keyframe_s = -math.inf
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self.encoded = 0
        self._encode_s = 0.0
        self._interval_s = 1.0 / settings.fps

    @property
    def load(self) -> float:
        """The part of its frame interval that a picture's encoding takes; above 1 some are skipped.

        It is the mean of the last pictures, 0 while paused or before a first one.
        """
        return self._encode_s / self._interval_s if self.wanted else 0.0

    @property
    def wanted(self) -> bool:
        return self._wanted.is_set()

    def want(self, wanted: bool) -> None:
        """Start or pause encoding; it starts with a keyframe, as soon as one is allowed."""
        if wanted and not self._wanted.is_set():
            self._keyframe.set()
            self._wanted.set()
        elif not wanted:
            self._wanted.clear()

    def request_keyframe(self, *, is_urgent: bool = False) -> None:
        """Make the next picture a keyframe, as soon as the spacing allows."""
        self._is_urgent = self._is_urgent or is_urgent
        self._keyframe.set()

    def start(self) -> None:
        name = f"encode {self.settings.name}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def request_stop(self) -> None:
        """Ask the thread to end after the current picture, and return at once."""
        self._stopping.set()
        self._wanted.set()
        self._slot.wake()

    def stop(self, timeout_s: float) -> None:
        """End the thread, waiting at most this long; safe to call twice."""
        self.request_stop()
        thread, self._thread = self._thread, None
        if thread is None:
            return
        thread.join(timeout=timeout_s)
        if thread.is_alive():
            _LOG.warning("encoder thread does not end; abandoned", rendition=self.settings.name)

    def _run(self) -> None:
        encoder: PictureEncoder | None = None
        while not self._stopping.is_set():
            if not self._wanted.wait(_KEEP_S):
                encoder = None
                self._wanted.wait()
            try:
                encoder = encoder or self._make_encoder()
                self._encode_while_wanted(encoder)
            except Exception:
                # A picture that breaks the encoder must not end the stream for good.
                _LOG.exception("encoder failed; restarting it", rendition=self.settings.name)
                encoder = None
                self._keyframe.set()
                self._stopping.wait(1.0)

    def _encode_while_wanted(self, encoder: PictureEncoder) -> None:
        # Skip the current picture: the other renditions will have sent it by then.
        number = self._slot.count
        spacing_s = 1.0 / self.settings.fps
        due_s = 0.0
        seen_s: float | None = None
        is_fresh = True
        while self._wanted.is_set() and not self._stopping.is_set():
            found = self._slot.newer_than(number, _POLL_S)
            if found is None:
                continue
            if seen_s is not None:
                interval_s = max((found[1].captured_s - seen_s) / (found[0] - number), spacing_s)
                self._interval_s += _LOAD_WEIGHT * (interval_s - self._interval_s)
            number, picture = found
            seen_s = picture.captured_s
            # Some tolerance, so that a camera's jitter does not halve the rate; less than half a
            # frame, because at twice the rate every second picture is early by exactly that.
            late_s = picture.captured_s - due_s
            if late_s < -0.4 * spacing_s:
                continue
            due_s = spacing_s + (due_s if late_s < spacing_s else picture.captured_s)
            began_s = self._clock.now_s()
            keyframe = self._keyframe_due(began_s, is_fresh=is_fresh)
            if is_fresh and not keyframe:
                continue
            encoded = encoder.encode(picture, keyframe=keyframe)
            if encoded is None:
                continue
            self._encode_s += _LOAD_WEIGHT * (self._clock.now_s() - began_s - self._encode_s)
            if encoded.keyframe:
                is_fresh, self._keyframe_s = False, self._clock.now_s()
            self.encoded += 1
            self._deliver(encoded)

    def _keyframe_due(self, now_s: float, *, is_fresh: bool) -> bool:
        since_s = now_s - self._keyframe_s
        is_requested = is_fresh or self._keyframe.is_set()
        may_be = since_s >= _KEYFRAME_SPACING_S and (
            self._keyframes.level(now_s) >= 1 or self._is_urgent
        )
        if not (is_requested and may_be) and since_s < self._keyframe_interval_s:
            return False
        self._keyframes.take(now_s)
        self._is_urgent = False
        self._keyframe.clear()  # one keyframe serves all requests and the interval
        return True
