"""Cells as cases of a suite: one event loop, on which link and browser live from cell to cell."""

from __future__ import annotations

import asyncio
import signal
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, Self, TypeVar

from tests.link.errors import LinkError

from e2e.delay.cell import Cell
from e2e.delay.measures import measured
from e2e.delay.stage import Stage
from e2e.delay.watch import watch
from e2e.instrument.error import own_error
from e2e.link import UnavailableError
from e2e.link.verify import verify
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row
from e2e.measure.suite import Case

if TYPE_CHECKING:
    from collections.abc import Coroutine
    from pathlib import Path

    from e2e.delay.results import CellResult

T = TypeVar("T")

BEYOND_S: Final = 100.0
"""What a cell may take beside its own time until it counts as hung."""
_LEAVE_WITHIN_S: Final = 15.0


class Apparatus:
    """``with Apparatus(folder) as apparatus``: what stands is taken away at the end.

    `folder` takes what the cells leave: the systems' logs and all that was read. With `strict` a
    cell without a picture has failed; else that is what was found.
    """

    def __init__(self, folder: Path, *, strict: bool, beyond_s: float = BEYOND_S) -> None:
        self._folder = folder
        self._strict = strict
        self._beyond_s = beyond_s
        self._stage = Stage()
        self._missing: dict[str, str] = {}
        self._loop = asyncio.Runner()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        # All has been measured, or something worse is already on its way up.
        with suppress(Exception):
            self._run(self._stage.clear())
        self._loop.close()

    def check(self, cell: Cell) -> None:
        """Have link and browser for a cell; raises `NotRunError` or `MeasureError`."""
        self._run(_told(self._stage.set_for(cell)))

    def case(self, cell: Cell) -> Case:
        return Case(cell.key, f"{cell.seconds:g} s", 1, lambda _: [self._row(cell)])

    def own_error(self) -> Case:
        return Case(
            "instrument", "the instrument's own error", 1, lambda _: self._run(_told(self._error()))
        )

    def emulator(self, profile: str) -> Case:
        return Case(
            f"emulator/{profile}",
            "what the emulator makes of a profile",
            1,
            lambda _: self._run(_told(_verified(profile))),
        )

    def _row(self, cell: Cell) -> Row:
        """Measure a cell: its figures by name. What the machine lacks is looked for once."""
        needs = f"{cell.system} {cell.content} {cell.browser}"
        if needs in self._missing:
            raise NotRunError(self._missing[needs])
        folder = self._folder / "cells" / cell.key.replace("/", "-")
        folder.mkdir(parents=True, exist_ok=True)
        try:
            result = self._run(self._bounded(cell, folder))
            if result.problem:
                self._run(self._clear())
                if self._strict:
                    raise MeasureError(result.problem)
        except NotRunError as error:
            self._missing[needs] = str(error)
            raise
        except Exception:
            self._run(self._clear())  # the next one starts afresh
            raise
        (folder / "read.json").write_text(result.model_dump_json(), encoding="utf-8")
        detail: dict[str, Any] = {"cell": cell.model_dump(), "limits": result.readings.limits}
        if result.problem:
            detail["problem"] = result.problem
        return Row(key=cell.key, what=cell.key, n=1, values=measured(result), detail=detail)

    async def _bounded(self, cell: Cell, folder: Path) -> CellResult:
        """Watch it, or cut it off; raises what it raised, or `MeasureError`."""
        bound_s = cell.seconds + self._beyond_s
        watching = asyncio.create_task(self._watch(cell, folder), name=cell.key)
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
        raise MeasureError(f"it hung and was cut off after {bound_s:.0f} s")

    async def _watch(self, cell: Cell, folder: Path) -> CellResult:
        async def watched() -> CellResult:
            await self._stage.set_for(cell)
            return await watch(cell, self._stage.link, self._stage.browser, folder)

        return await _told(watched())

    async def _error(self) -> list[Row]:
        await self._stage.set_for(
            Cell(experiment="E3", profile="same-machine", system="audio-master")
        )
        folder = self._folder / "cells" / "instrument"
        folder.mkdir(parents=True, exist_ok=True)
        return await own_error(self._stage.link, self._stage.browser, folder)

    async def _clear(self) -> None:
        """Start over; the next cell ignores how the old stage ends."""
        with suppress(Exception):  # a browser that failed may fail at its end as well
            await self._stage.clear()

    def _run(self, work: Coroutine[Any, Any, T]) -> T:
        async def interruptible() -> T:
            loop, task = asyncio.get_running_loop(), asyncio.current_task()
            assert task is not None
            loop.add_signal_handler(signal.SIGTERM, task.cancel)  # nothing is left behind either
            return await work

        try:
            return self._loop.run(interruptible())
        except asyncio.CancelledError:
            raise KeyboardInterrupt from None


async def _told(work: Coroutine[Any, Any, T]) -> T:
    """Let what is wrong with a link be what is wrong with a measurement."""
    try:
        return await work
    except UnavailableError as error:
        raise NotRunError(str(error)) from error
    except LinkError as error:
        raise MeasureError(str(error)) from error


async def _verified(profile: str) -> list[Row]:
    """Verify one profile, some 10 s: each figure as promised and as measured, and what is allowed.

    The goal is that it is off by no more than what is allowed.
    """
    found = await verify(profile)
    return [
        Row(
            key=f"emulator/{profile}/{way}/{figure.name}",
            what=f"{profile}, {way}: {figure.name}",
            n=1,
            values={
                "promised": figure.promised,
                "measured": figure.measured,
                "off": abs(figure.measured - figure.promised),
            },
            judged="off",
            goal=figure.allowed,
            met=figure.ok,
        )
        for way, figures in found.figures.items()
        for figure in figures
    ]
