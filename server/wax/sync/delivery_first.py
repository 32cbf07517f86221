"""When the live policies deliver first and synchronise second: the thesis's fail-safe mode.

The thesis (3.3, 3.5) enters it when a picture takes as long as an audio media unit (3.4), when too
few pictures get through, or when the sound is too late. Here the link's estimate, the ladder and
the sound's delay are the equivalent signals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.sync.sound_delay import SoundDelay

_ENTER_S: Final = 1.0
_LEAVE_S: Final = 4.0


def insufficient(
    estimate: LinkEstimate | None, allocation: Allocation | None, sound: SoundDelay
) -> Sentence | None:
    """Return why the link cannot carry both sound and picture; None if it can."""
    if sound.is_useless:
        return Sentence("sync.sound_breaks")
    if allocation is not None and allocation.step is None:
        return Sentence("sync.no_picture_fits")
    if estimate is not None and estimate.state == "congested":
        return Sentence("sync.congested")
    return None


class DeliveryFirst:
    """Becomes active after 1 s with a reason, and inactive after 4 s without one."""

    def __init__(self) -> None:
        self._trouble_since_s: float | None = None
        self._peace_since_s: float | None = None
        self.reason: Sentence | None = None

    @property
    def is_active(self) -> bool:
        return self.reason is not None

    def update(self, trouble: Sentence | None, now_s: float) -> None:
        """Update with the current reason, None for none; `now_s` never falls."""
        if trouble is None:
            self._trouble_since_s = None
            if self._peace_since_s is None:
                self._peace_since_s = now_s
            if now_s - self._peace_since_s >= _LEAVE_S:
                self.reason = None
            return
        self._peace_since_s = None
        if self._trouble_since_s is None:
            self._trouble_since_s = now_s
        if self.is_active or now_s - self._trouble_since_s >= _ENTER_S:
            self.reason = trouble

    def leave(self) -> None:
        """Become inactive regardless of the link, as when only one stream is wanted."""
        self.reason = self._trouble_since_s = self._peace_since_s = None
