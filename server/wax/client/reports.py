"""Makes the page's playout report for a client without screen and speaker (pure)."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from wax.protocol import messages

if TYPE_CHECKING:
    from wax.client.media import FrameArrival, StreamCounts
    from wax.client.sdp import Kind

INTERVAL_S: Final = 0.25
_UNSETTLED: Final = 40
"""This many reports are all sent after a stream begins; then an observer sends every fourth."""
_EVERY: Final = 4
_RATE_OVER_S: Final = 1.0
_UINT32: Final = 2**32


@dataclass(frozen=True, slots=True)
class ReceivedStream:
    """What has arrived of one stream; `newest` is None before the first frame."""

    counts: StreamCounts
    newest: FrameArrival | None


class Reporter:
    """Reports media as played as soon as the server's target allows.

    The picture has no age: nothing is shown, as in a hidden page.
    """

    def __init__(self) -> None:
        self._sound_target_ms = 0.0
        self._clocks: dict[str, messages.RtpClock] = {}
        self._began_s: float | None = None
        self._counted: deque[tuple[int, float]] = deque()
        self._count = 0

    def handle(self, message: dict[str, Any]) -> None:
        """Handle a message of the state channel; all but two kinds are ignored."""
        if message["type"] == "playout":
            self._sound_target_ms = message["sound_target_ms"] or 0.0
        elif message["type"] == "rtp_clock":
            clock = messages.RtpClock(**message)
            self._clocks[clock.kind] = clock

    def is_due(self, *, eager: bool) -> bool:
        """Count one interval; return whether a report is sent at its end."""
        self._count += 1
        return eager or self._count <= _UNSETTLED or self._count % _EVERY == 0

    def report(
        self,
        *,
        sound: ReceivedStream | None,
        picture: ReceivedStream | None,
        now_s: float,
        ahead_ms: float,
        clock_error_ms: float | None,
    ) -> messages.Report:
        """Return the current report; a stream that is off is None.

        `ahead_ms` is how far the server's clock is ahead of the one of `now_s`.
        """
        return messages.Report(
            type="report",
            sound=None if sound is None else self._sound(sound, now_s, ahead_ms),
            picture=None if picture is None else self._picture(picture, now_s),
            clock_error_ms=clock_error_ms,
        )

    def _sound(self, sound: ReceivedStream, now_s: float, ahead_ms: float) -> messages.SoundReport:
        age_ms = played_ms = concealed_ms = None
        if sound.newest is not None:
            self._began_s = self._began_s or sound.newest.at_s
            played_ms = (now_s - self._began_s) * 1000
            counts = sound.counts
            concealed_ms = played_ms * counts.lost / max(1, counts.lost + counts.packets)
            age_ms = self.age_ms("audio", sound.newest, ahead_ms)
        return messages.SoundReport(
            age_ms=None if age_ms is None else age_ms + self._sound_target_ms,
            delay_ms=self._sound_target_ms,
            output_ms=None,
            concealed_ms=concealed_ms,
            played_ms=played_ms,
            stretched_ms=None,
            player="browser",
        )

    def _picture(self, picture: ReceivedStream, now_s: float) -> messages.PictureReport:
        counted = self._counted
        counted.append((picture.counts.frames, now_s))
        while len(counted) > 2 and now_s - counted[1][1] >= _RATE_OVER_S:
            counted.popleft()
        frames, since_s = counted[0]
        passed_s = now_s - since_s
        rate_hz = (picture.counts.frames - frames) / passed_s if passed_s > 0 else None
        return messages.PictureReport(age_ms=None, delay_ms=None, rate_hz=rate_hz, frozen_ms=None)

    def age_ms(self, kind: Kind, newest: FrameArrival, ahead_ms: float) -> float | None:
        """Return a frame's age on arrival; None before its stream's clock is known."""
        captured_ms = self.captured_ms(kind, newest.rtp)
        return None if captured_ms is None else newest.at_s * 1000 + ahead_ms - captured_ms

    def captured_ms(self, kind: Kind, rtp: int) -> float | None:
        """Return when it was captured by the server's clock; None before that stream's is known."""
        clock = self._clocks.get(kind)
        if clock is None:
            return None
        ticks = (rtp - clock.rtp_origin + _UINT32 // 2) % _UINT32 - _UINT32 // 2
        return clock.origin_server_ms + ticks * 1000 / clock.rate_hz
