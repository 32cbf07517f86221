"""When the sound is back, judged from what was heard."""

from __future__ import annotations

import pytest

from e2e.measure.ear import Block
from e2e.strangers.reconnect import heard_after


@pytest.mark.parametrize(
    ("loud", "heard_ms"),
    [
        ("111111111111111111", 0.0),
        ("110000000111111111", 0.0),  # before the link was back
        ("110000000000011111", 30.0),
        ("111111111111000000", None),
        ("111111111110000011", 60.0),  # buffered sound has played on
        ("111111111111011110", 0.0),  # crackles
    ],
)
def test_the_sound_is_back_when_the_silence_of_a_lost_link_ends(
    loud: str, heard_ms: float | None
) -> None:
    """The link is back after 100 ms; each digit is 10 ms."""
    blocks = [Block(10.0 * at, float(one), 0.0, 0.0) for at, one in enumerate(loud)]
    assert heard_after(blocks, 100.0) == heard_ms
