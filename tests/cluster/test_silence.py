"""When a media server that reports each second counts as gone."""

from __future__ import annotations

from wax.cluster.silence import SILENT_S, Silence


def test_a_server_that_reports_no_more_is_gone() -> None:
    """A server is gone at the second check that misses three reports."""
    silence = Silence()
    looks = [silence.is_certain(0.2 * number) for number in range(20)]
    assert looks.index(True) == int(SILENT_S / 0.2) + 2


def test_a_process_that_stood_still_accuses_nobody() -> None:
    """One silent check is not enough: after a pause of our own, pending reports are unread."""
    silence = Silence()
    assert not any(silence.is_certain(unheard_s) for unheard_s in (0.5, 6.0, 0.1, 4.0, 0.0))
