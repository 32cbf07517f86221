"""Decides what is sent to one viewer, and when: chapter 3.3 of the thesis as a state machine.

Sound is the master and goes first; the picture is rolled back to it. A unit that cannot be sent in
time is skipped at the source. On an insufficient link both go as soon as possible.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from wax.baseline.equations import pictures_to_cache
from wax.baseline.fail_safe import BaselineFailSafe, LinkMeasurements
from wax.baseline.master_stream import MasterStream
from wax.baseline.picture_cache import PictureCache
from wax.baseline.transfer_time import LeastRoundTrip, TransferTime
from wax.baseline.virtual_clock import VirtualClock

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.baseline.media_units import MediaUnit, Stream
    from wax.config.thesis import ThesisSettings
    from wax.sentence import Sentence

Mode = Literal["one stream", "start-up", "synchronised", "fail-safe"]


@dataclass(frozen=True, slots=True)
class Decision:
    """What to do now.

    `send` goes on the wire at once, sound first. Units in `skipped` will never be sent; those in
    `lost` were sent and given up; neither will appear again. `wake_s` is when to call `tick`.
    """

    send: tuple[MediaUnit, ...]
    skipped: tuple[MediaUnit, ...]
    lost: tuple[MediaUnit, ...]
    wake_s: float


@dataclass(frozen=True, slots=True)
class State:
    """The sender's state, for display; None is unknown or meaningless.

    `hold_back_s` is T_p (3.1), `transfer_s` T_r, `pictures_cached` N_v (3.2 to 3.4); `reason` says
    why fail-safe mode is on.
    """

    mode: Mode
    reason: Sentence | None
    hold_back_s: float | None
    transfer_s: float | None
    pictures_cached: int | None
    rollback_s: float | None


class UnitSender:
    """One viewer's sender; methods take the time, which never falls, and return a `Decision`.

    Start-up (thesis 3.3.3.2): until the first audio MU leaves, pictures go as soon as possible.
    Then the newest picture goes at once and the next only T_p later; meanwhile T_r is measured.
    """

    def __init__(
        self, settings: ThesisSettings, *, sound: bool = True, picture: bool = True
    ) -> None:
        self._settings = settings
        self._audio_mu_s = settings.audio_mu_ms / 1000
        self._video_mu_s = settings.video_mu_ms / 1000
        self._sound_wanted = sound
        self._picture_wanted = picture
        self._round_trip = LeastRoundTrip()
        self._sound = MasterStream(settings, self._round_trip)
        self._picture = TransferTime(self._round_trip, lost_after_s=settings.lost_after_ms / 1000)
        self._cache = PictureCache()
        self._fail_safe = BaselineFailSafe(settings)
        self._extra_s = 0.0
        self._heard_s: float | None = None
        self._newest: dict[Stream, int] = {}
        self._clock: VirtualClock | None = None
        self._hold_back_s: float | None = None
        self._hold_until_s: float | None = None
        self._send: list[MediaUnit] = []
        self._skipped: list[MediaUnit] = []

    # --- events ------------------------------------------------------------------------------

    def choose(self, *, sound: bool, picture: bool, now_s: float) -> Decision:
        """Change which streams are wanted; returns to start-up."""
        if (sound, picture) != (self._sound_wanted, self._picture_wanted):
            self._sound_wanted, self._picture_wanted = sound, picture
            self._fail_safe.leave()
            self._restart()
        if not sound:
            self._skip(self._sound.clear())
        if not picture:
            self._skipped += self._cache.resize(0)
            self._skip(self._cache.take_oldest())
        return self._decide(now_s)

    def captured(self, mu: MediaUnit, now_s: float) -> Decision:
        """Handle a complete MU; raises `ValueError` if it is not newer than the last."""
        if mu.number <= self._newest.get(mu.stream, mu.number - 1):
            raise ValueError(f"{mu} is not newer than number {self._newest[mu.stream]}")
        self._newest[mu.stream] = mu.number
        if mu.stream == "sound" and self._sound_wanted:
            self._heard_s = now_s
            self._skip(self._sound.put(mu, now_s))
        elif mu.stream == "picture" and self._picture_wanted:
            self._skipped += self._cache.put(mu, now_s)
        return self._decide(now_s)

    def acknowledged(self, stream: Stream, number: int, now_s: float) -> Decision:
        """Handle the page's acknowledgement of an MU; only the one in flight counts."""
        (self._sound if stream == "sound" else self._picture).acknowledged(number, now_s)
        return self._decide(now_s)

    def round_trip(self, round_trip_s: float, now_s: float) -> Decision:
        """Handle a measured round trip; only the shortest counts."""
        self._round_trip.seen(round_trip_s)
        return self._decide(now_s)

    def roll_back_further(self, extra_s: float, now_s: float) -> Decision:
        """Roll the picture back by `extra_s` more than the sound's own age (thesis 5.3.1)."""
        longest_s = self._settings.max_extra_rollback_ms / 1000
        self._extra_s = min(max(extra_s, 0.0), longest_s)
        if self._clock is not None:
            self._clock.extra_s = self._extra_s
        return self._decide(now_s)

    def tick(self, now_s: float) -> Decision:
        """Decide again after time has passed."""
        return self._decide(now_s)

    # --- state -------------------------------------------------------------------------------

    @property
    def mode(self) -> Mode:
        if not self._both:
            return "one stream"
        if self._fail_safe.is_active:
            return "fail-safe"
        return "start-up" if self._clock is None or self._is_held else "synchronised"

    def state(self) -> State:
        transfer_s = self._picture.seconds
        cached = None
        if transfer_s is not None and self._both:
            cached = pictures_to_cache(
                transfer_s * 1000,
                audio_mu_ms=self._settings.audio_mu_ms,
                video_mu_ms=self._settings.video_mu_ms,
            )
        return State(
            mode=self.mode,
            reason=self._fail_safe.reason,
            hold_back_s=self._hold_back_s,
            transfer_s=transfer_s,
            pictures_cached=0 if self._fail_safe.is_active else cached,
            rollback_s=None if self._clock is None else self._clock.rollback_s,
        )

    # --- decisions ---------------------------------------------------------------------------

    @property
    def _both(self) -> bool:
        return self._sound_wanted and self._picture_wanted

    @property
    def _is_held(self) -> bool:
        """Whether V_2 is not sent yet, T_p is not over, or T_r is not known yet."""
        return self._hold_back_s is None or self._hold_until_s is not None

    def _decide(self, now_s: float) -> Decision:
        lost = [self._sound.give_up(now_s), self._picture.give_up(now_s)]
        self._skip(self._sound.expire(now_s))
        self._judge(now_s)
        self._send_sound(now_s)
        wake_s = self._send_picture(now_s)
        decision = Decision(
            send=tuple(self._send),
            skipped=tuple(self._skipped),
            lost=tuple(mu for mu in lost if mu is not None),
            wake_s=min(wake_s, now_s + self._video_mu_s),
        )
        self._send, self._skipped = [], []
        return decision

    def _judge(self, now_s: float) -> None:
        """Enter or leave fail-safe mode; restart if the sound has stopped at its source."""
        if not self._both:
            return
        was_active = self._fail_safe.is_active
        self._fail_safe.update(self._measured(now_s), now_s)
        if self._fail_safe.is_active != was_active:
            self._restart()
        if self._heard_s is not None and now_s - self._heard_s > 2 * self._audio_mu_s:
            self._heard_s = None
            self._restart()

    def _measured(self, now_s: float) -> LinkMeasurements:
        interval_s = self._picture.last_interval_s
        if self._picture.under_way is not None:
            interval_s = max(interval_s or 0.0, now_s - self._picture.under_way.left_s)
        return LinkMeasurements(
            transfer_s=self._picture.at_least_s(now_s),
            interval_s=interval_s,
            sound_delay_s=self._sound.delay_s(now_s),
        )

    def _restart(self) -> None:
        """Forget the alignment of the streams, but keep the units in flight."""
        self._clock = self._hold_back_s = self._hold_until_s = None
        self._sound.forget_delay()
        if not self._fail_safe.is_active:
            self._picture.forget()

    def _send_sound(self, now_s: float) -> None:
        if (mu := self._sound.pop(now_s)) is None:
            return
        self._send.append(mu)
        if self._both and not self._fail_safe.is_active and self._clock is None:
            self._clock = VirtualClock(self._settings, mu, now_s)
            self._clock.extra_s = self._extra_s

    def _send_picture(self, now_s: float) -> float:
        """Send the picture that may be sent now, if any; return when to check again."""
        if not self._picture_wanted:
            return now_s + self._video_mu_s
        clock = self._clock
        if clock is None or self._hold_back_s is None:
            self._skipped += self._cache.resize(0)
            picture = self._send_next(self._cache.take_oldest, now_s)
            if picture is not None and clock is not None:
                self._hold_back_s = clock.hold_back_s(picture)
                self._hold_until_s = clock.due_s(picture)
                self._skipped += self._cache.resize(clock.capacity(0.0))
            return now_s + self._video_mu_s
        return self._send_in_time(clock, now_s)

    def _send_in_time(self, clock: VirtualClock, now_s: float) -> float:
        transfer_s = self._picture.seconds
        self._skipped += self._cache.resize(clock.capacity(transfer_s or 0.0))
        if self._hold_until_s is not None:
            if now_s < self._hold_until_s:
                return self._hold_until_s
            if transfer_s is None:
                return now_s + self._video_mu_s
            self._hold_until_s = None
        if self._picture.under_way is None:
            self._send_due(clock, transfer_s or 0.0, now_s)
        if self._picture.under_way is not None or not self._cache.pictures:
            return now_s + self._video_mu_s
        return clock.due_s(self._cache.pictures[0])

    def _send_due(self, clock: VirtualClock, transfer_s: float, now_s: float) -> None:
        """Send the newest picture that is due; earlier ones are too late.

        If pictures take V or longer, the cache itself is the delay, N_v times T_r: the oldest is
        sent as soon as the link is free and the cache is full. Timely delivery comes first.
        """
        due = [mu for mu in self._cache.pictures if clock.due_s(mu) <= now_s]
        if due:
            self._skipped += self._cache.skip_before(due[-1].number)
        elif self._cache.capacity and (transfer_s < self._video_mu_s or not self._cache.is_full):
            return
        self._send_next(self._cache.take_oldest, now_s)
        self._cache.fill()

    def _send_next(self, take: Callable[[], MediaUnit | None], now_s: float) -> MediaUnit | None:
        if self._picture.under_way is not None or (picture := take()) is None:
            return None
        self._picture.left(picture, now_s)
        self._send.append(picture)
        return picture

    def _skip(self, mu: MediaUnit | None) -> None:
        if mu is not None:
            self._skipped.append(mu)
