"""A clock that is turned by hand."""

from __future__ import annotations

import pytest


class FakeClock:
    """Stands still until it is turned, or until somebody waits on it."""

    def __init__(self) -> None:
        self.time_s = 1000.0

    def now_s(self) -> float:
        return self.time_s

    def wall_ms(self) -> int:
        return 0

    def wait(self, pause_s: float) -> bool:
        """Let so much time pass at once."""
        self.time_s += pause_s
        return False


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()
