"""Media units, and the slot at the source in which the newest of them waits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Stream = Literal["sound", "picture"]


@dataclass(frozen=True, slots=True)
class MediaUnit:
    """The piece in which a stream is captured, stored and sent (thesis 3.3).

    `number` rises within a stream. `captured_s` is when its capture *began*, as in Figure 3.7;
    a picture is taken at the end of its interval, so it shows the scene at `ready_s`.
    """

    stream: Stream
    number: int
    captured_s: float
    duration_s: float

    @property
    def ready_s(self) -> float:
        """When its capture is complete; it cannot be sent before (thesis 3.3.3.2)."""
        return self.captured_s + self.duration_s


class SourceSlot:
    """Holds the newest MU until it is taken, replaced or too old (thesis 3.3).

    "The audio MU in the buffer is valid until the next audio MU is ready": it expires after
    `longest_wait_s` in the slot. A picture has no such limit (None).
    """

    def __init__(self, longest_wait_s: float | None = None) -> None:
        self._longest_wait_s = longest_wait_s
        self._mu: MediaUnit | None = None
        self._put_s = 0.0

    @property
    def held(self) -> MediaUnit | None:
        return self._mu

    @property
    def expires_s(self) -> float | None:
        """When the held MU expires; None if there is none or it has no limit."""
        if self._mu is None or self._longest_wait_s is None:
            return None
        return self._put_s + self._longest_wait_s

    def put(self, mu: MediaUnit, now_s: float) -> MediaUnit | None:
        """Replace the held MU; return the one that is thereby skipped."""
        replaced, self._mu, self._put_s = self._mu, mu, now_s
        return replaced

    def take(self) -> MediaUnit | None:
        """Remove and return the held MU."""
        taken, self._mu = self._mu, None
        return taken

    def expire(self, now_s: float) -> MediaUnit | None:
        """Drop and return an MU that has waited too long."""
        expires_s = self.expires_s
        return self.take() if expires_s is not None and now_s > expires_s else None
