"""The diagnosis of a relay that does not work."""

from __future__ import annotations

from tests.free_port import free_port

from wax.rtc.relay_check import problem


def test_an_unreachable_relay_is_diagnosed() -> None:
    """An unused port and an unknown name are each diagnosed."""
    port = free_port()
    told = problem(f"turn:127.0.0.1:{port}?transport=tcp", "me", "word")
    assert str(told).startswith(f"Nobody listens at 127.0.0.1:{port}")
    assert "nowhere.invalid" in str(problem("turns:nowhere.invalid:443", "me", "word"))
