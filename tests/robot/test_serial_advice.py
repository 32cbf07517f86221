"""What is allowed in `[robot.serial]` and yet worth a warning."""

from __future__ import annotations

from typing import Any

import pytest

from wax.config.serial import SerialSettings
from wax.robot.serial.advice import NO_END, NO_TTL, advised


def of(dialect: str, drive: str = "m {left} {right}\r", **text: Any) -> SerialSettings:
    lines = {"drive": drive, "per_mps": 1.0, **text}
    return SerialSettings.model_validate({"dialect": dialect, "text": lines})


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (of("text", ttl_ms=500), []),
        (of("text"), [NO_TTL]),
        (of("text", "m {left} {right}\n", ttl_ms=500), []),
        (of("text", "<{left},{right}>", ttl_ms=500), [NO_END]),
        (of("text", "<{left},{right}>"), [NO_TTL, NO_END]),
        (of("frames", "<{left},{right}>"), []),
    ],
)
def test_a_possible_mistake_is_a_warning(settings: SerialSettings, said: list[Any]) -> None:
    """A missing watchdog or line end is a warning, for the dialect in use only."""
    assert advised(settings) == said
