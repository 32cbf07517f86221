"""Runs the trials of hardware encoders in another process for a limited time."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import asdict
from typing import TYPE_CHECKING, Final

from wax.encode.hardware import Hardware, is_built_in
from wax.encode.trial import Trial
from wax.machine import python_module

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.video import RenditionSettings

LIMIT_S: Final = 8.0
"""Trials take less than a second on most machines, a few on a small one that has just booted."""
_DIES_WITHIN_S: Final = 1.0
_COMMAND: Final = ("-P", "-m", "wax.encode.trial")  # -P: import nothing from the working directory


def try_all(
    candidates: Sequence[Hardware],
    renditions: Sequence[RenditionSettings],
    *,
    limit_s: float = LIMIT_S,
    command: Sequence[str] = _COMMAND,
) -> list[Trial]:
    """Try each candidate in order; one that hangs or crashes gets a `problem`.

    Then its process ends and the others continue in a new one, for at most twice `limit_s` in all.
    """
    there = [one for one in candidates if is_built_in(one.name)]
    end_s = time.monotonic() + 2 * limit_s
    found: dict[str, Trial] = {}
    while left := [one for one in there if one.name not in found]:
        within_s = min(limit_s, end_s - time.monotonic())
        if within_s <= 0:
            found |= {one.name: Trial(one.name, problem="it was not tried in time") for one in left}
            break
        trials, end = _run(left, renditions, within_s, command)
        found |= {one.encoder: one for one in trials}
        if len(trials) < len(left):  # the next candidate ended the process
            guilty = left[len(trials)].name
            found[guilty] = Trial(guilty, problem=end)
    absent = "PyAV is built without it here"
    return [found.get(one.name) or Trial(one.name, problem=absent) for one in candidates]


def _run(
    candidates: Sequence[Hardware],
    renditions: Sequence[RenditionSettings],
    within_s: float,
    command: Sequence[str],
) -> tuple[list[Trial], str]:
    """Return the completed trials in order, and how the process ended."""
    asked = {
        "candidates": [asdict(one) for one in candidates],
        "renditions": [one.model_dump() for one in renditions],
    }
    try:
        process = subprocess.Popen(
            [sys.executable, *command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=python_module.environment(),
            start_new_session=True,
        )
    except OSError as error:
        return [], f"its trial could not be started ({error})"
    try:
        told, _ = process.communicate(json.dumps(asked).encode(), timeout=within_s)
        end = f"its trial ended early ({_how(process.returncode)})"
    except subprocess.TimeoutExpired as late:
        process.kill()
        told, end = _rest(process, late), "its trial did not end in time"
    except BaseException:
        process.kill()
        raise
    return [one for line in told.splitlines() if (one := _trial(line)) is not None], end


def _rest(process: subprocess.Popen[bytes], late: subprocess.TimeoutExpired) -> bytes:
    """Return a killed process's output; one that hangs in a driver may survive the kill."""
    try:
        return process.communicate(timeout=_DIES_WITHIN_S)[0]
    except subprocess.TimeoutExpired:
        return late.stdout or b""


def _how(code: int) -> str:
    return f"signal {-code}" if code < 0 else f"status {code}"


def _trial(line: bytes) -> Trial | None:
    try:
        return Trial(**json.loads(line))
    except (ValueError, TypeError):  # other output, or an incomplete line
        return None
