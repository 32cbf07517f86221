"""Our own policy instead of the server of 2004, so that the two can be compared."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING

from wax.baseline.media_units import MediaUnit
from wax.baseline.unit_sender import UnitSender
from wax.config.thesis import ThesisSettings

if TYPE_CHECKING:
    from wax.baseline.unit_sender import Decision


class Baseline:
    """The sender of `wax.baseline` with only sound, for a client that asks.

    In 2004 a client asked for the next MU when it had the last; today the page acknowledges the
    last. So a request is an acknowledgement, and the first request is the connection, at which the
    client gets the MU "currently in the buffer" (3.3.3.2).
    """

    def __init__(self, mu_ms: int, ready_ms: list[float]) -> None:
        self._mu_s = mu_ms / 1000
        self._ready_ms = ready_ms
        self._sender = UnitSender(ThesisSettings(audio_mu_ms=mu_ms), picture=False)
        self._captured = 0
        self._now_ms = 0.0
        self._wake_ms = math.inf
        self.given: list[tuple[int, float]] = []
        self.skipped: list[int] = []

    def answer_ms(self, asked_ms: float) -> float | None:
        """See `Server`; raises `RuntimeError` if asked so late that the last MU is given up.

        The sender waits for a second or longer; TCP, which lost nothing, needed no limit.
        """
        before = len(self.given)
        if not before:
            self._connect(asked_ms)
        while self._next_ms() <= asked_ms:
            self._step()
        self._now_ms = asked_ms
        if before:
            number, _ = self.given[-1]
            self._obey(self._sender.acknowledged("sound", number, asked_ms / 1000))
        while len(self.given) == before and self._captured < len(self._ready_ms):
            self._step()
        return self.given[-1][1] if len(self.given) > before else None

    def _connect(self, asked_ms: float) -> None:
        held = bisect_right(self._ready_ms, asked_ms)
        self._captured = max(0, held - 1)
        self.skipped += range(self._captured)
        self._now_ms = asked_ms

    def _next_ms(self) -> float:
        return max(self._now_ms, min(self._captured_ms(), self._wake_ms))

    def _captured_ms(self) -> float:
        left = self._captured < len(self._ready_ms)
        return self._ready_ms[self._captured] if left else math.inf

    def _step(self) -> None:
        """Deliver the next MU or tick, whichever is due first."""
        is_capture = self._captured_ms() <= self._wake_ms
        self._now_ms = self._next_ms()
        if is_capture:
            number, self._captured = self._captured, self._captured + 1
            mu = MediaUnit("sound", number, number * self._mu_s, self._mu_s)
            self._obey(self._sender.captured(mu, self._now_ms / 1000))
        else:
            self._obey(self._sender.tick(self._now_ms / 1000))

    def _obey(self, decision: Decision) -> None:
        if decision.lost:
            raise RuntimeError(f"MU {decision.lost[0].number} was given up before it was asked on")
        self.given += [(mu.number, self._now_ms) for mu in decision.send]
        self.skipped += [mu.number for mu in decision.skipped]
        self._wake_ms = decision.wake_s * 1000
