"""A run from its first look at the machine to its report."""

from __future__ import annotations

import asyncio
import shlex
import sys
import time
import traceback
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from e2e.lab.emulator import verified
from e2e.lab.errors import LabError
from e2e.lab.folder import REPORT, RUN, Begun, RunFolder, utc
from e2e.lab.instrument.error import own_error
from e2e.lab.progress import Progress, count, duration
from e2e.lab.report import pick, write
from e2e.lab.report.model2004 import rows
from e2e.lab.report.sections import goals
from e2e.lab.results import CellResult, Run
from e2e.lab.runner import Runner
from e2e.lab.stage import Stage
from e2e.lab.watch import watch
from e2e.measure import machine

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.lab.cell import Cell
    from e2e.lab.wanted import Wanted


async def begin(wanted: Wanted) -> int:
    """Measure what is wanted; returns the exit status.

    Raises `LabError` or `LinkError`, and then nothing was written, when it cannot be measured
    here.
    """
    cells = wanted.cells()
    stage = Stage()
    try:
        await stage.set_for(cells[0])  # what this machine lacks is told before all else
        begun = Begun(
            started_utc=utc(),
            arguments=sys.argv[1:],
            machine=await _describe(stage),
            cells=cells,
            own_error=not wanted.quick,
            strict=wanted.quick,
            verify=wanted.long,
        )
        return await _go_on(RunFolder.create(wanted.out, begun), stage)
    finally:
        await _leave(stage)


async def resume(path: Path | None) -> int:
    """Measure what a run has left, and again what failed in it; otherwise as `begin`."""
    folder = RunFolder.unfinished(path)
    stage = Stage()
    try:
        left = folder.begun.left(folder.results())
        if left:
            await stage.set_for(left[0])
        return await _go_on(folder, stage)
    finally:
        await _leave(stage)


async def _go_on(folder: RunFolder, stage: Stage) -> int:
    before = folder.results()
    left = folder.begun.left(before)
    began_s = time.monotonic() - sum(result.took_s for result in before)
    progress = Progress(left, before=len(folder.begun.cells) - len(left))
    progress.say(f"{count(left)}, about {duration(progress.left_s())}, into {folder.path}")

    async def watch_one(cell: Cell) -> CellResult:
        result = await watch(cell, stage.link, stage.browser, folder.files_of(cell))
        if result.status == "ok":
            folder.drop_files_of(cell)
        return result

    try:
        # As with cells: what failed before is measured again.
        if folder.begun.own_error and not folder.begun.instrument.get("ok"):
            progress.say("the instrument's own error …")
            folder.begun.instrument = await _own_error(folder)
            folder.save()
        if folder.begun.verify:
            await verify_emulator(folder, progress)
        await Runner(folder, stage, watch_one, progress).run(left)
    except asyncio.CancelledError:
        arguments = shlex.quote(f"--resume {shlex.quote(str(folder.path))}")
        progress.say(f"\nstopped; the rest is measured by: make lab ARGS={arguments}")
        raise
    await _leave(stage)
    return _finish(folder, time.monotonic() - began_s, progress)


def _finish(folder: RunFolder, took_s: float, progress: Progress) -> int:
    """Write run and report, say where they are, and return the exit status."""
    run = Run(
        started_utc=folder.begun.started_utc,
        took_s=took_s,
        arguments=folder.begun.arguments,
        machine=folder.begun.machine,
        cells=folder.results(),
        client2004=rows(),
        instrument=folder.begun.instrument,
        emulator=folder.begun.emulator,
    )
    folder.finish(run)
    write_report(run, folder)
    counts = {
        status: sum(result.status == status for result in run.cells)
        for status in ("ok", "failed", "not run")
    }
    told = ", ".join(f"{number} {status}" for status, number in counts.items() if number)
    progress.say(f"{told} in {duration(took_s)}: {folder.path / RUN}, {folder.path / REPORT}")
    if any(result.cell.experiment == "G" for result in run.cells):
        for line in goals.text(pick.entries(run)):
            progress.say(line)
    lost = [result for result in run.cells if result.status == "failed"]
    if not folder.begun.strict:
        lost = [result for result in lost if result.figures is None]
    return 1 if lost else 0


def write_report(run: Run, folder: RunFolder) -> None:
    """Write the page; raises `LabError` whatever goes wrong: the run itself is on the disk."""
    path = folder.path / REPORT
    try:
        write(run, path)
    except Exception as error:
        with suppress(LabError):  # the disk may take neither
            folder.log(f"{path}\n{traceback.format_exc()}")
        why = getattr(error, "strerror", None) or f"{type(error).__name__}: {error}"
        raise LabError(
            f"{path} cannot be written ({why}); nothing that was measured is lost, the page is "
            f"made by: python -m e2e.lab.report {shlex.quote(str(folder.path / RUN))}"
        ) from error


async def _describe(stage: Stage) -> dict[str, Any]:
    described = await asyncio.to_thread(machine.describe)
    statistics = await stage.link.statistics()
    return {**described.model_dump(), "real_time": statistics.real_time}


async def _own_error(folder: RunFolder) -> dict[str, Any]:
    try:
        return await own_error()
    except LabError as error:
        folder.log(f"the instrument's own error: {error}")
        return {"problem": str(error)}


async def verify_emulator(folder: RunFolder, progress: Progress) -> None:
    """Verify what this run uses of the emulator, as far as that is not done."""
    begun = folder.begun
    known = {found["profile"] for found in begun.emulator}
    for profile in dict.fromkeys(cell.profile for cell in begun.cells):
        if profile not in known:
            progress.say(f"the emulator's {profile} …")
            begun.emulator.append(await verified(profile))
            folder.save()


async def _leave(stage: Stage) -> None:
    # Everything has been measured, or something worse is already on its way up.
    with suppress(Exception):
        await stage.clear()
