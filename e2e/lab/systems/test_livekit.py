"""LiveKit at the server's end: its command line, its refusals, and that all of it is one family."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools
import pytest

from e2e.harness.missing import missing
from e2e.lab.cell import Cell
from e2e.lab.link import Link, UnavailableError
from e2e.lab.systems import livekit
from e2e.lab.systems.livekit import LiveKitRunning, check_installed, command
from e2e.measure.errors import MeasureError, NotRunError
from e2e.peers.livekit import installation
from e2e.peers.livekit.__main__ import parse

if TYPE_CHECKING:
    from pathlib import Path


def test_its_own_program_takes_the_command_line(tmp_path: Path) -> None:
    """It is told the address at its end, and a film only where there is one."""
    asked = parse(command("sdk", "10.77.0.1", None)[2:])
    assert asked.how == "sdk"
    assert str(asked.host) == "10.77.0.1"
    assert asked.media is None
    film = tmp_path / "film.mp4"
    assert parse(command("whip", "10.77.0.1", film)[2:]).media == film


@pytest.mark.parametrize(
    ("missing_part", "said"),
    [("_BUILT", "Go"), ("_PACKAGE", "make check"), ("_SDK", "the package livekit")],
)
def test_what_is_missing_is_not_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, missing_part: str, said: str
) -> None:
    """Without LiveKit's server, or its client, a cell is not run, and one sentence says why."""
    program = tmp_path / "livekit-server"
    program.touch(0o755)
    monkeypatch.delenv("WAX_LIVEKIT", raising=False)
    monkeypatch.setattr(installation, "_BUILT", program)
    monkeypatch.setattr(installation, missing_part, type(getattr(installation, missing_part))("no"))
    with pytest.raises(NotRunError, match=said) as refusal:
        check_installed("sdk")
    assert "\n" not in str(refusal.value)


class Page:
    """A window whose page says what it is given, the last for ever."""

    def __init__(self, *says: str) -> None:
        self._says = list(says)

    async def goto(self, url: str) -> None:
        raise NotImplementedError

    async def evaluate(self, expression: str) -> Any:
        return self._says.pop(0) if len(self._says) > 1 else self._says[0]

    async def hold(self, key: str) -> None:
        raise NotImplementedError


class Health:
    """A server that is well."""

    url = "http://10.77.0.1:8080"
    pid = 1


async def test_it_is_open_when_the_page_plays() -> None:
    """The page is asked again until it is connected and its sound is on."""
    running = LiveKitRunning(Health())  # type: ignore[arg-type]  # nothing is asked of it
    page = Page("connecting", "its sound is off", "connected")
    await running.opened(page)
    assert page._says == ["connected"]


async def test_a_page_that_does_not_play_says_what_it_says(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The page's own words are in the sentence when it does not play in time."""
    monkeypatch.setattr(livekit, "_PLAYS_WITHIN_S", 0.0)
    running = LiveKitRunning(Health())  # type: ignore[arg-type]  # nothing is asked of it
    with pytest.raises(MeasureError, match="not connected: no token"):
        await running.opened(Page("not connected: no token"))


@pytest.mark.timeout(90)
@pytest.mark.parametrize("system", ["livekit", "livekit-whip"])
async def test_it_serves_at_its_end_and_leaves_nothing(system: Any, tmp_path: Path) -> None:
    """Over a link it publishes, tells its versions, and all its processes end with the block."""
    try:
        check_installed("sdk" if system == "livekit" else "whip")
    except NotRunError as error:
        pytest.skip(str(error))
    try:
        cell = Cell(experiment="E2", profile="lan", system=system)
        async with Link("lan") as link:
            async with livekit.start(cell, link, tmp_path) as running:
                told = await running.told()
                family = psutil.Process(running.pid).children(recursive=True)
                assert len(family) == 2
                assert told["livekit_server"] == "1.11.0"
                assert told["published"] == 1
            assert not [child for child in family if child.is_running()]
    except UnavailableError as error:
        missing(str(error))
