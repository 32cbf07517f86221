"""Cell after cell: what fails is a cell that says so, and the next one starts afresh."""

from __future__ import annotations

import asyncio
import time
import traceback
from contextlib import suppress
from typing import TYPE_CHECKING, Final, Literal, Protocol

from e2e.lab.errors import LabError, NotRunError
from e2e.lab.folder import utc
from e2e.lab.link import LinkError
from e2e.lab.results import CellResult

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from e2e.lab.cell import Cell
    from e2e.lab.folder import RunFolder
    from e2e.lab.progress import Progress

BEYOND_S: Final = 100.0
"""What a cell may take beside its own time until it counts as hung."""
_LEAVE_WITHIN_S: Final = 15.0


class Scene(Protocol):
    """What a cell is played on, as `e2e.lab.stage.Stage`."""

    async def set_for(self, cell: Cell) -> None: ...

    async def clear(self) -> None: ...


class Runner:
    """Measures cells by `watch`, which may rely on the scene, and keeps each in the folder."""

    def __init__(
        self,
        folder: RunFolder,
        scene: Scene,
        watch: Callable[[Cell], Awaitable[CellResult]],
        progress: Progress,
        *,
        beyond_s: float = BEYOND_S,
    ) -> None:
        self._folder = folder
        self._scene = scene
        self._watch = watch
        self._progress = progress
        self._beyond_s = beyond_s
        self._not_run: dict[str, str] = {}

    async def run(self, cells: Sequence[Cell]) -> None:
        """Measure them all; raises `LabError` only where the folder does not take the results."""
        for cell in cells:
            self._progress.begin(cell)
            result = await self._result(cell)
            self._folder.add(result)
            self._progress.end(result)
            if result.status == "failed":
                await self._clear()

    async def _result(self, cell: Cell) -> CellResult:
        started_utc, started_s = utc(), time.monotonic()

        def unmeasured(status: Literal["failed", "not run"], problem: str) -> CellResult:
            took_s = time.monotonic() - started_s
            return CellResult(
                cell=cell, status=status, problem=problem, started_utc=started_utc, took_s=took_s
            )

        if _needs(cell) in self._not_run:
            return unmeasured("not run", self._not_run[_needs(cell)])
        try:
            result = await self._bounded(cell)
        except NotRunError as error:
            self._not_run[_needs(cell)] = str(error)
            return unmeasured("not run", str(error))
        except (LabError, LinkError) as error:
            self._folder.log(f"{cell.key}\n{traceback.format_exc()}")
            return unmeasured("failed", _first_line(error))
        except Exception as error:  # whatever it is, the other cells are not to be lost
            self._folder.log(f"{cell.key}\n{traceback.format_exc()}")
            return unmeasured("failed", f"{type(error).__name__}: {_first_line(error)}")
        return result.model_copy(
            update={"started_utc": started_utc, "took_s": time.monotonic() - started_s}
        )

    async def _bounded(self, cell: Cell) -> CellResult:
        """Watch it, or cut it off; raises what it raised, or `LabError`."""
        bound_s = cell.seconds + self._beyond_s
        watching = asyncio.create_task(self._set_and_watch(cell), name=cell.key)
        try:
            await asyncio.wait({watching}, timeout=bound_s)
            if watching.done():
                return watching.result()
        finally:
            watching.cancel()
            await asyncio.wait({watching}, timeout=_LEAVE_WITHIN_S)
            if not watching.done():  # what it waits for ends with the link
                await self._clear()
                await asyncio.wait({watching}, timeout=_LEAVE_WITHIN_S)
        with suppress(asyncio.CancelledError, Exception):
            watching.result()
        raise LabError(f"it hung and was cut off after {bound_s:.0f} s")

    async def _set_and_watch(self, cell: Cell) -> CellResult:
        await self._scene.set_for(cell)
        return await self._watch(cell)

    async def _clear(self) -> None:
        """Begin anew; how the old scene ends is of no interest to the next cell."""
        try:
            await self._scene.clear()
        except Exception:  # a browser that failed may fail at its end as well
            self._folder.log(f"the scene did not end well\n{traceback.format_exc()}")


def _needs(cell: Cell) -> str:
    """Name what a cell needs of the machine; where that is missing once it is missing again."""
    return f"{cell.system} {cell.content} {cell.browser}"


def _first_line(error: Exception) -> str:
    """Take the sentence; what a system's error goes on with is the end of its log."""
    first, _, _ = str(error).strip().partition("\n")
    return first.removesuffix("; its log ends:")
