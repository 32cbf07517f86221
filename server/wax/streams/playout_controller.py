"""Runs one viewer's playout policy and applies its targets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.protocol import messages
from wax.sync.policies import make_policy

if TYPE_CHECKING:
    from wax.config.sync import SyncSettings
    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.streams.interface import Page
    from wax.sync.playout import PlayoutReport, PlayoutTargets

_RETARGET_MS: Final = 4.0
"""Smaller changes of a target are skipped: each one makes the picture jump a little."""


class PlayoutController:
    """Holds the picture back by RTP's playout delay if supported, else by the browser's buffer."""

    def __init__(self, page: Page, sync: SyncSettings) -> None:
        self._page = page
        self._policy = make_policy(sync)
        self._player = sync.player
        self._targets: PlayoutTargets | None = None
        self._held_ms: float | None = None
        self._is_ready = False

    @property
    def preroll_ms(self) -> float:
        """The pre-roll of the sound in ms."""
        return self._policy.preroll_ms

    @property
    def is_in_step(self) -> bool:
        """False while the link cannot carry both and each plays as soon as it can."""
        return self._targets is None or self._targets.in_step

    def connected(self) -> None:
        """Show pictures at once until the sound has been measured."""
        self._delay_pictures(0.0)

    def ready(self) -> None:
        """Send the targets to the page, once the data channels are open."""
        self._is_ready = True
        self._retarget(self._policy.start())

    def change_policy(self, sync: SyncSettings) -> None:
        """Change the policy; keep what is known about the link."""
        self._policy = make_policy(sync, self._policy.state)
        self._player = sync.player
        self._targets = None  # send the new name and reason even if the targets are the same
        if self._is_ready:
            self._retarget(self._policy.start())

    def reported(
        self,
        report: PlayoutReport,
        now_s: float,
        estimate: LinkEstimate,
        allocation: Allocation | None,
    ) -> None:
        """Decide again after a report, given the estimate of the link."""
        self._retarget(self._policy.decide(report, now_s, estimate, allocation))

    def status(self) -> dict[str, object]:
        known: dict[str, object] = {"policy": self._policy.name}
        if self._targets is not None:
            known |= {
                "sound_target_ms": self._targets.sound_ms,
                "picture_held_ms": self._held_ms,
                "why_in_step": str(self._targets.reason),
            }
        return known

    def _retarget(self, targets: PlayoutTargets) -> None:
        if self._targets is not None and not _moved(self._targets, targets):
            return
        self._targets = targets
        by_server = self._delay_pictures(targets.picture_ms or 0.0)
        self._page.send(
            messages.Playout(
                policy=self._policy.name,
                player=self._player,
                sound_target_ms=targets.sound_ms,
                picture_target_ms=None if by_server else targets.picture_ms,
                reason=targets.reason,
            )
        )

    def _delay_pictures(self, least_ms: float) -> bool:
        self._held_ms = least_ms
        return self._page.set_playout_delay(least_ms)


def _moved(old: PlayoutTargets, new: PlayoutTargets) -> bool:
    def differ(a: float | None, b: float | None) -> bool:
        if a is None or b is None:
            return a is not b
        # Skip small changes, but always reach zero.
        return abs(a - b) >= _RETARGET_MS or (b == 0 and a != 0)

    return (
        differ(old.sound_ms, new.sound_ms)
        or differ(old.picture_ms, new.picture_ms)
        or old.in_step != new.in_step
    )
