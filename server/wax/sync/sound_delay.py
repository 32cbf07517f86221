"""The smallest delay at which the sound plays without gaps on one viewer's link.

A browser adapts its own delay (NetEq: about what 97 of 100 packets need, reached by stretching the
sound by 75 ms a second). It is left alone until this viewer's packets, or concealed sound, show
that it is too short; then it gets a minimum.
"""

from __future__ import annotations

from collections import deque
from math import ceil, isfinite
from typing import Final

BOUND_MS: Final = 500.0
"""The longest delay: the thesis's audio media unit."""

_STEP_MS: Final = 10.0
"""The step between delays, the same as that of the video's playout-delay."""

_LEAST_MS: Final = 20.0
"""A browser buffers this much anyway, so that a smaller target asks for nothing."""

_WINDOW_S: Final = 2.0
"""The window in which concealment is summed. Ours."""

_BRIDGED_MS: Final = 60.0
"""Concealment that is hardly heard, because a decoder continues the wave (NetEq: for 100 ms, then
it fades). More than this within the window is a break, as is a packet that is later than this."""

_USELESS_MS: Final = 100.0
"""With more concealment than this at the longest delay, waiting is no use. Ours."""

_GRACE_S: Final = 1.0
"""For this long after the sound or its encoding begins, concealment says nothing about the link.
Ours."""

_NEW_SHARE: Final = 0.25
"""The weight of a new measurement of the device in the mean. Ours."""

_RISE_MS: Final = (20.0, 120.0)
"""The least and the most by which a break raises the delay. Ours."""

_STRETCH_MS_PER_S: Final = 75.0
"""The rate at which browsers stretch the sound, as measured in Chromium."""

_SHOWN_S: Final = 0.5
"""How long the page takes to report a rise once the sound is stretched: two reports. Ours."""

_PATIENCE_S: Final = (7.0, 600.0)
"""The delay falls after this long without a break. A break that a fall caused makes this four times
as long, up to the second value. Ours."""

_TRIAL_S: Final = 3.0
"""A break this soon after a fall was caused by it; a later one is the link's next stall. The delay
never falls below what packets needed within this time. Ours."""

_FALL_EVERY_S: Final = 1.0
"""The interval between further falls. Ours."""

_FALL_SHARE: Final = 0.3
"""The share of unneeded delay that a fall removes, until one causes a break; then a step. Ours."""


class SoundDelay:
    """Raises the delay at once, and within 15 s of the last gap lowers it to what packets need.

    After a fall that causes a gap at once, the next one waits four times as long and is one step,
    so that such gaps become rare on a steady link. A configured delay (`fixed_ms`) is fixed: it is
    the total until the sound is heard, so the device's delay is subtracted from the buffer's.
    """

    def __init__(self, fixed_ms: float | None, *, bound_ms: float = BOUND_MS) -> None:
        self.fixed_ms = fixed_ms
        self._device = _Device()
        self._bound_ms = bound_ms
        self._level_ms = 0.0
        self._heard = _Heard()
        self._encoding: tuple[int, int] | None = None
        self._now_s = float("-inf")
        self._calm_since_s = float("-inf")
        self._patience_s = _PATIENCE_S[0]
        self._fell_s = self._disturbed_s = float("-inf")
        self._needs: deque[tuple[float, float]] = deque()

    @property
    def target_ms(self) -> float | None:
        """The minimum for the browser's buffer; None leaves it to the browser."""
        if self.fixed_ms is not None:
            return max(self.fixed_ms - self._device.output_ms, _LEAST_MS)
        return self._level_ms if self._level_ms > _LEAST_MS else None

    @property
    def is_breaking(self) -> bool:
        """Whether the sound had gaps within the last two seconds."""
        return self._heard.concealed_ms > _BRIDGED_MS

    @property
    def is_useless(self) -> bool:
        """Whether the sound has gaps even at the longest delay allowed."""
        at_bound = self.fixed_ms is None and self._level_ms >= self._bound_ms
        return at_bound and self._heard.concealed_ms > _USELESS_MS

    def restart(self) -> None:
        """Leave the delay to the browser, and start over."""
        self._level_ms = 0.0

    def decide(
        self,
        *,
        # 99.x % of the sound packets arrive within this time after the fastest.
        jitter_ms: float,
        mu_ms: int,
        # The number of later packets that repeat a lost unit, if the buffer waits for them.
        redundancy: int,
        # The page's counters, which may restart; None if unknown.
        concealed_ms: float | None,
        played_ms: float | None,
        now_s: float,
        # The share of packets lost, which no delay restores, and how many are lost in a row.
        lost: float = 0.0,
        burst: int = 0,
        # Congestion control drains the link's queue, so its jitter does not raise the delay.
        is_congested: bool = False,
        # If False, the delay does not change.
        learns: bool = True,
        # The part of the delay in the device.
        output_ms: float | None = None,
    ) -> float | None:
        """Return the target after a report."""
        self._device.update(output_ms)
        self._now_s = now_s = max(now_s, self._now_s) if isfinite(now_s) else self._now_s
        if (mu_ms, redundancy) != self._encoding or is_congested:
            self._encoding = (mu_ms, redundancy)
            self._heard.ignore(now_s + _GRACE_S)
        self._heard.count(concealed_ms, played_ms, now_s)
        if self.fixed_ms is not None or is_congested or not learns:
            return self.target_ms
        jitter_ms = max(jitter_ms, 0.0) if isfinite(jitter_ms) else 0.0
        late_ms = max(jitter_ms - _BRIDGED_MS, 0.0)
        need_ms = min(late_ms + redundancy * mu_ms + _STEP_MS, self._bound_ms)
        self._needs.append((now_s, need_ms))
        while now_s - self._needs[0][0] > _TRIAL_S:
            self._needs.popleft()
        allowed_ms = 1.5 * lost * _WINDOW_S * 1000 + (burst * mu_ms if lost > 0 else 0)
        broken_ms = self._heard.concealed_ms - (allowed_ms if isfinite(allowed_ms) else 0.0)
        if broken_ms > _BRIDGED_MS:
            self._rise(broken_ms, now_s)
        if need_ms > self._level_ms:
            rise_ms = need_ms - self._level_ms
            self._level_ms = min(_steps(need_ms), self._bound_ms)
            self._note_disturbance(rise_ms, now_s)
        elif now_s - self._calm_since_s >= self._patience_s:
            self._fall(max(need for _, need in self._needs), now_s)
        return self.target_ms

    def _rise(self, broken_ms: float, now_s: float) -> None:
        self._note_disturbance(broken_ms, now_s)
        if self._level_ms >= self._bound_ms:
            return
        rise_ms = min(max(broken_ms, _RISE_MS[0]), _RISE_MS[1])
        level_ms = _steps(max(self._level_ms, _LEAST_MS) + rise_ms)
        self._level_ms = min(level_ms, self._bound_ms)
        self._heard.ignore(now_s + rise_ms / _STRETCH_MS_PER_S + _SHOWN_S)

    def _note_disturbance(self, short_ms: float, now_s: float) -> None:
        was_s, self._disturbed_s = self._disturbed_s, now_s
        self._calm_since_s = now_s
        if now_s - self._fell_s <= _TRIAL_S:
            self._patience_s = min(4 * self._patience_s, _PATIENCE_S[1])
        elif now_s - was_s > _TRIAL_S and short_ms > _RISE_MS[0]:
            self._patience_s = _PATIENCE_S[0]
        self._fell_s = float("-inf")

    def _fall(self, need_ms: float, now_s: float) -> None:
        if self._level_ms <= _LEAST_MS:
            self._patience_s = _PATIENCE_S[0]
            return
        above_ms = self._level_ms - need_ms
        if need_ms > _LEAST_MS and above_ms < 2.5 * _STEP_MS:
            return  # within the variation of what packets need
        # While any packet is late, one step more than the least stays, for the same reason.
        least_ms = _LEAST_MS + _STEP_MS if need_ms > _STEP_MS else _LEAST_MS
        if self._level_ms <= least_ms:
            return
        is_new = self._patience_s == _PATIENCE_S[0]
        fall_ms = _steps(_FALL_SHARE * above_ms) if is_new else _STEP_MS
        self._level_ms = max(self._level_ms - fall_ms, _steps(need_ms), least_ms)
        self._fell_s = now_s
        self._calm_since_s = now_s - self._patience_s + _FALL_EVERY_S


class _Device:
    """The delay of the viewer's audio device, smoothed and in steps that a buffer can follow."""

    def __init__(self) -> None:
        self.output_ms = 0.0
        self._mean_ms: float | None = None

    def update(self, output_ms: float | None) -> None:
        """Add a measurement, which varies by about 10 ms, because the device reads in blocks."""
        if output_ms is None or not isfinite(output_ms):
            return
        output_ms = min(max(output_ms, 0.0), BOUND_MS)
        mean_ms = output_ms if self._mean_ms is None else self._mean_ms
        self._mean_ms = mean_ms + (output_ms - mean_ms) * _NEW_SHARE
        if abs(self._mean_ms - self.output_ms) >= _STEP_MS:
            self.output_ms = round(self._mean_ms / _STEP_MS) * _STEP_MS


class _Heard:
    """The amount of sound concealed within the window."""

    def __init__(self) -> None:
        self._last: tuple[float, float] | None = None
        self._ignored_until_s = float("-inf")
        self._made_up: deque[tuple[float, float]] = deque()

    @property
    def concealed_ms(self) -> float:
        return sum(ms for _, ms in self._made_up)

    def ignore(self, until_s: float) -> None:
        self._ignored_until_s = max(self._ignored_until_s, until_s)
        self._made_up.clear()

    def count(self, concealed_ms: float | None, played_ms: float | None, now_s: float) -> None:
        while self._made_up and now_s - self._made_up[0][0] > _WINDOW_S:
            self._made_up.popleft()
        if concealed_ms is None or played_ms is None:
            return
        if not (isfinite(concealed_ms) and isfinite(played_ms)):
            return
        last, self._last = self._last, (concealed_ms, played_ms)
        if last is None or concealed_ms < last[0] or played_ms < last[1]:
            self.ignore(now_s + _GRACE_S)
        elif now_s >= self._ignored_until_s:
            # Concealment cannot exceed what was played.
            made_up_ms = min(concealed_ms - last[0], played_ms - last[1])
            if made_up_ms > 0:
                self._made_up.append((now_s, made_up_ms))


def _steps(ms: float) -> float:
    return ceil(ms / _STEP_MS) * _STEP_MS
