"""A failure is a cell that says so: the runner with a scene and a watch that obey."""

from __future__ import annotations

import asyncio
import io
from typing import TYPE_CHECKING

import pytest

from e2e.lab.cell import Cell
from e2e.lab.errors import LabError, NotRunError
from e2e.lab.folder import LOG, Begun, RunFolder
from e2e.lab.progress import Progress
from e2e.lab.results import CellResult
from e2e.lab.runner import BEYOND_S, Runner

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    Watch = Callable[[Cell], Awaitable[CellResult]]

CELLS = [Cell(experiment="E1", profile="lan", system="thesis", audio_mu_ms=mu) for mu in (100, 200)]
PEERS = [Cell(experiment="E2", profile=profile, system="livekit") for profile in ("lan", "campus")]


class Scene:
    """Notes what is asked of it."""

    def __init__(self) -> None:
        self.said: list[str] = []

    async def set_for(self, cell: Cell) -> None:
        self.said.append(cell.profile)

    async def clear(self) -> None:
        self.said.append("cleared")


class Stuck(Scene):
    """A scene whose cell hangs until it is cleared."""

    def __init__(self) -> None:
        super().__init__()
        self.gone = asyncio.Event()

    async def clear(self) -> None:
        await super().clear()
        self.gone.set()


def ok(cell: Cell) -> CellResult:
    return CellResult(cell=cell, status="ok", started_utc="", took_s=0.0)


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    begun = Begun(started_utc="", arguments=[], machine={}, cells=[], own_error=False, strict=True)
    return RunFolder.create(tmp_path / "run", begun)


async def play(
    folder: RunFolder,
    watch: Watch,
    cells: list[Cell],
    *,
    scene: Scene | None = None,
    beyond_s: float = BEYOND_S,
) -> tuple[Scene, str]:
    scene, out = scene or Scene(), io.StringIO()
    await Runner(folder, scene, watch, Progress(cells, out), beyond_s=beyond_s).run(cells)
    return scene, out.getvalue()


async def test_a_failed_cell_costs_no_other(folder: RunFolder) -> None:
    """What a cell raises becomes its sentence, its traceback goes to the log, and the next runs."""

    async def watch(cell: Cell) -> CellResult:
        if cell is CELLS[0]:
            raise ValueError("the page is odd\nand more")
        return ok(cell)

    scene, said = await play(folder, watch, CELLS)
    first, second = folder.results()
    assert (first.status, first.problem) == ("failed", "ValueError: the page is odd")
    assert second.status == "ok"
    assert "Traceback" in (folder.path / LOG).read_text()
    assert scene.said == ["lan", "cleared", "lan"]
    assert "failed: ValueError: the page is odd" in said


async def test_a_result_without_a_picture_starts_the_next_afresh(folder: RunFolder) -> None:
    """A cell that failed without raising keeps its figures, and the link is not used again."""

    async def watch(cell: Cell) -> CellResult:
        return ok(cell).model_copy(update={"status": "failed", "problem": "no picture"})

    scene, _ = await play(folder, watch, CELLS[:1])
    assert folder.results()[0].problem == "no picture"
    assert scene.said == ["lan", "cleared"]


async def test_what_is_missing_is_looked_for_once(folder: RunFolder) -> None:
    """A system that cannot be had is asked for once, told once, and not run each time."""
    asked: list[Cell] = []

    async def watch(cell: Cell) -> CellResult:
        asked.append(cell)
        if cell.system == "livekit":
            raise NotRunError("there is no Go")
        return ok(cell)

    _, said = await play(folder, watch, [*PEERS, CELLS[0]])
    results = folder.results()
    assert [result.status for result in results] == ["not run", "not run", "ok"]
    assert [result.problem for result in results] == ["there is no Go", "there is no Go", None]
    assert asked == [PEERS[0], CELLS[0]]
    assert said.count("there is no Go") == 1


@pytest.mark.parametrize("stubborn", [False, True])
async def test_a_hung_cell_is_cut_off(
    folder: RunFolder, monkeypatch: pytest.MonkeyPatch, *, stubborn: bool
) -> None:
    """A cell that does not end is ended, with its link where it holds on to that."""
    monkeypatch.setattr("e2e.lab.runner._LEAVE_WITHIN_S", 0.05)
    scene = Stuck()

    async def watch(cell: Cell) -> CellResult:
        try:
            await asyncio.Event().wait()
        finally:
            if stubborn:
                await scene.gone.wait()
        raise AssertionError

    short = CELLS[0].model_copy(update={"seconds": 0.0})
    await play(folder, watch, [short], scene=scene, beyond_s=0.05)
    (result,) = folder.results()
    assert result.status == "failed"
    assert result.problem is not None
    assert result.problem.startswith("it hung")
    # Others' tasks may be on this loop: the browser of the session's tests is.
    assert short.key not in {task.get_name() for task in asyncio.all_tasks()}


async def test_an_interrupted_run_keeps_what_it_has(folder: RunFolder) -> None:
    """Cancelled in a cell: that one is left out, its watch has ended, those before are kept."""
    ended: list[Cell] = []
    waits = asyncio.Event()

    async def watch(cell: Cell) -> CellResult:
        if cell is CELLS[0]:
            return ok(cell)
        try:
            waits.set()
            await asyncio.Event().wait()
        finally:
            ended.append(cell)
        raise AssertionError

    playing = asyncio.create_task(play(folder, watch, CELLS))
    await waits.wait()
    playing.cancel()
    with pytest.raises(asyncio.CancelledError):
        await playing
    assert [result.cell for result in folder.results()] == [CELLS[0]]
    assert ended == [CELLS[1]]


async def test_a_folder_that_takes_nothing_ends_the_run(folder: RunFolder) -> None:
    """Results that cannot be kept are worth no further cell."""
    asked: list[Cell] = []

    async def watch(cell: Cell) -> CellResult:
        asked.append(cell)
        folder.path = folder.path / "gone"
        return ok(cell)

    with pytest.raises(LabError, match="cannot write"):
        await play(folder, watch, CELLS)
    assert asked == [CELLS[0]]


async def test_progress_says_number_name_and_rest(folder: RunFolder) -> None:
    """Each cell has a line with its place, its name, how it went, and what is left."""

    async def watch(cell: Cell) -> CellResult:
        return ok(cell)

    _, said = await play(folder, watch, CELLS)
    first, second = said.splitlines()
    assert first.startswith("[1/2] E1/lan/thesis/100ms … ok 0 s, about ")
    assert first.endswith(" left")
    assert second == "[2/2] E1/lan/thesis/200ms … ok 0 s"
