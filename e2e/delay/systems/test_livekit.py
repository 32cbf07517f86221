"""LiveKit at the server's end: what it refuses, and when its page is open."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest

from e2e.delay.cell import Cell
from e2e.delay.systems import peers
from e2e.delay.systems.peers import LiveKitRunning, check_installed
from e2e.measure.errors import MeasureError, NotRunError
from e2e.peers.livekit import installation

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.delay.names import SystemName


def cell(system: SystemName) -> Cell:
    return Cell(experiment="E2", profile="lan", system=system)


@pytest.mark.parametrize(
    ("missing_part", "said"),
    [("_BUILT", "Go"), ("_PACKAGE", "make check"), ("_SDK", "package livekit")],
)
def test_what_is_missing_is_not_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, missing_part: str, said: str
) -> None:
    """Without LiveKit's server, client or SDK a cell is not run, and one sentence says why."""
    program = tmp_path / "livekit-server"
    program.touch(0o755)
    monkeypatch.delenv("WAX_LIVEKIT", raising=False)
    monkeypatch.setattr(installation, "_BUILT", program)
    monkeypatch.setattr(installation, missing_part, type(getattr(installation, missing_part))("no"))
    with pytest.raises(NotRunError, match=said) as refusal:
        check_installed("sdk")
    assert "\n" not in str(refusal.value)


def page(*says: str) -> Any:
    """Make a window whose page says what it is given, the last for ever."""
    left = list(says)

    async def evaluate(_: str) -> str:
        return left.pop(0) if len(left) > 1 else left[0]

    return SimpleNamespace(evaluate=evaluate, left=left)


async def test_it_is_open_when_the_page_plays(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page is asked until it is connected and heard; in time, or its words are the error."""
    running = LiveKitRunning(SimpleNamespace(url="http://10.77.0.1:8080", pid=1))  # type: ignore[arg-type]  # nothing is asked of it
    window = page("connecting", "its sound is off", "connected")
    await running.opened(window)
    assert window.left == ["connected"]
    monkeypatch.setattr(peers, "_PLAYS_WITHIN_S", 0.0)
    with pytest.raises(MeasureError, match="not connected: no token"):
        await running.opened(page("not connected: no token"))
