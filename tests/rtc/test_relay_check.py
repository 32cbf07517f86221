"""What is said of a relay that does not carry."""

from __future__ import annotations

from tests.free_port import free_port

from wax.rtc.relay_check import problem


def test_a_relay_that_is_not_there_says_why() -> None:
    """A port that nobody has, and a name that there is not."""
    port = free_port()
    told = problem(f"turn:127.0.0.1:{port}?transport=tcp", "me", "word")
    assert str(told).startswith(f"Nobody listens at 127.0.0.1:{port}")
    assert "nowhere.invalid" in str(problem("turns:nowhere.invalid:443", "me", "word"))
