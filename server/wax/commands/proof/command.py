"""`wax prove-stop`: ask, prove, write the record."""

from __future__ import annotations

import asyncio
import contextlib
import os
import platform
import signal
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax import __version__
from wax.commands.proof import record
from wax.commands.proof.config_file import check, check_stop
from wax.commands.proof.proof import Progress, Proof
from wax.errors import ConfigError, StartError, reason_of
from wax.sentence import Sentence
from wax.session.proof_runner import NOT_ALL

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.commands.proof.verdict import Findings
    from wax.config.settings import Settings

MAX_REPEATS: Final = 1000
_STDIN: Final = 0
_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def prove_stop(
    settings: Settings,
    *,
    repeats: int,
    path: Path | None,
    confirm: Callable[[], bool],
    tell: Callable[[Progress], None],
    has_parent: bool = False,
) -> int:
    """Prove the stop, write the record to `path` or the working directory, and report the verdict.

    Returns 0 if each link was cut and each stop was in time, `NOT_ALL` if that holds for the links
    that can be cut on this robot, but not all can, else 1.
    With a parent process, the end of standard input means that the parent ended; it aborts the
    proof.

    `confirm` must make sure that the wheels are off the floor. Raises `ConfigError` for wrong
    usage, another `WaxError` if the proof cannot begin.
    """
    if not 1 <= repeats <= MAX_REPEATS:
        raise ConfigError(f"--repeats: got {repeats}; allowed is a number from 1 to {MAX_REPEATS}")
    check(settings)
    if not has_parent:  # which knows
        check_stop(settings)
    if not confirm():
        raise ConfigError("nothing was moved: lift the wheels off the floor first")
    begun = datetime.now().astimezone()
    path = path or Path(f"prove-stop-{begun:%Y-%m-%d-%H%M}.html")
    if not path.parent.is_dir() or not os.access(path.parent, os.W_OK):
        raise ConfigError(f"--record: {path} cannot be written; choose another place")
    try:
        proof = Proof(settings, repeats=repeats, tell=tell)
        findings = asyncio.run(_run(proof, has_parent=has_parent))
    except asyncio.CancelledError:
        raise StartError("the proof was aborted before the robot moved") from None
    heading = record.RecordHeading(
        date=f"{begun:%Y-%m-%d %H:%M %Z}",
        machine=f"{platform.node()}, {platform.platform()}, Python {platform.python_version()}",
        version=__version__,
    )
    try:
        path.write_text(record.page(findings, settings, heading), encoding="utf-8")
    except OSError as error:
        raise StartError(f"the record {path} cannot be written: {reason_of(error)}") from error
    cuts = sum(len(finding.samples) for finding in findings.findings)
    tell(Progress(Sentence("proof.record_at", {"path": str(path)}), cuts, cuts))
    tell(Progress(record.sentence(findings), cuts, cuts))
    if not findings.all_passed:
        return 1
    return NOT_ALL if findings.skipped else 0


async def _run(proof: Proof, *, has_parent: bool) -> Findings:
    """Run the proof so that however it ends, the robot stops first."""
    loop = asyncio.get_running_loop()
    task = asyncio.current_task()
    assert task is not None

    def break_off() -> None:
        for number in _SIGNALS:  # a second signal must not disturb the clean-up
            loop.add_signal_handler(number, _do_nothing)
        task.cancel()

    def listen() -> None:
        if not os.read(_STDIN, 1024):
            loop.remove_reader(_STDIN)
            break_off()

    for number in _SIGNALS:
        loop.add_signal_handler(number, break_off)
    if has_parent:
        with contextlib.suppress(PermissionError):  # not a pipe but a file, which never ends
            loop.add_reader(_STDIN, listen)
    return await proof.run()


def _do_nothing() -> None:
    """Ignore a signal."""
