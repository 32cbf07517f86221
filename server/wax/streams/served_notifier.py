"""Notifies a page of what it is sent: of changes at once, of figures periodically."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.protocol import messages

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.streams.interface import Page

_EVERY_S: Final = 1.0
_THIN_EVERY_S: Final = 5.0
"""The time between messages on a slow link."""
_THIN_BPS: Final = 150_000


class ServedNotifier:
    """Notifies one page, but not while the link's rate is only assumed."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._told: messages.Served | None = None
        self._told_s = float("-inf")

    def notify(
        self,
        estimate: LinkEstimate,
        allocation: Allocation,
        *,
        in_step: bool,
        cameras: Sequence[str | None],
        now_s: float,
    ) -> None:
        """Notify the page of a change at once, or of new figures after an interval."""
        if estimate.assumed:
            return
        told = self._told
        rendition = None if allocation.step is None else allocation.step.name
        channels = 0 if allocation.sound is None else allocation.sound.channels
        now = (rendition, channels, in_step, list(cameras))
        is_news = told is None or now != (
            told.rendition,
            told.sound_channels,
            told.in_step,
            told.cameras,
        )
        every_s = _THIN_EVERY_S if estimate.rate_bps < _THIN_BPS else _EVERY_S
        if not is_news and now_s - self._told_s < every_s:
            return
        self._told_s = now_s
        message = served(estimate, allocation, in_step=in_step, cameras=cameras)
        if message != told:
            self._told = message
            self._page.send(message)


def served(
    estimate: LinkEstimate,
    allocation: Allocation,
    *,
    in_step: bool,
    cameras: Sequence[str | None],
) -> messages.Served:
    """Return what is sent, and the link's estimate, for the page and the status."""
    step, sound = allocation.step, allocation.sound
    left_out = 0 if step is None else step.layers - allocation.top_layer
    return messages.Served(
        rendition=None if step is None else step.name,
        layers=None if step is None else allocation.top_layer + 1,
        layers_made=None if step is None else step.layers + 1,
        picture_hz=0.0 if step is None else step.fps / 2**left_out,
        sound_mu_ms=None if sound is None else sound.mu_ms,
        sound_bps=0 if sound is None else sound.bitrate_bps,
        sound_channels=0 if sound is None else sound.channels,
        redundancy=allocation.redundancy,
        link_bps=_rounded(estimate.rate_bps),
        used_bps=_rounded(estimate.used_bps),
        queue_ms=round(estimate.queue_ms / 10) * 10.0,
        in_step=in_step,
        reason=allocation.reason,
        cameras=list(cameras),
    )


def _rounded(rate_bps: float) -> int:
    """Round a rate to two digits, which is its accuracy."""
    return int(float(f"{rate_bps:.2g}"))
