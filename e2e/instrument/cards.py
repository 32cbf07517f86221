"""The test card with a clock that lies on purpose, to see whether the instrument notices.

For the server's configuration: ``source = "e2e.instrument.cards:LyingVideo"``, and ``LyingAudio``.
Their clock is honest for one second of Unix time, then `LIE_MS` behind for one, and so on. So each
lie has the truth before and after it in the same session. A difference between sessions, or a drift
such as that of a jitter buffer, is therefore no error of the instrument.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.capture.testcard import TestCardAudio, TestCardVideo

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.audio import AudioSettings
    from wax.config.video import VideoSettings

LIE_MS: Final = 100


def lies(wall_ms: float) -> bool:
    """Return whether the cards' clock is behind at this moment of true Unix time.

    It changes at half seconds, far from the bursts.
    """
    return (wall_ms + 500) // 1000 % 2 == 1


class LyingClock:
    """A true monotonic clock, and a wall clock that is behind at times."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock

    def now_s(self) -> float:
        return self._clock.now_s()

    def wall_ms(self) -> int:
        wall_ms = self._clock.wall_ms()
        return wall_ms - LIE_MS if lies(wall_ms) else wall_ms


class LyingVideo(TestCardVideo):
    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        super().__init__(settings, LyingClock(clock))


class LyingAudio(TestCardAudio):
    def __init__(self, settings: AudioSettings, clock: Clock) -> None:
        super().__init__(settings, LyingClock(clock))
