"""Repairs the parts that a killed server or a power cut has left without their end.

When a server starts, this runs in a separate process: `python -m wax.tape.repair` reads the folder
from its standard input and writes a sentence for each part. So neither damaged files in FFmpeg nor
the processor time can harm the process that drives.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final

import structlog

from wax.errors import StateError, reason_of
from wax.machine import python_module
from wax.machine.priority import lower_priority
from wax.state_dir import lock
from wax.tape.event_ending import ending_of, finish
from wax.tape.repaired import finish_media
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from wax.tape.shelf import Shelved

_LOG = structlog.get_logger(__name__)

_MODULE: Final = "wax.tape.repair"
_WITHIN_S: Final = 900.0
_LOOK_S: Final = 0.01


@dataclass(slots=True)
class Mended:
    """The repaired parts, and a sentence for each file that could not be repaired."""

    parts: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


def repair(shelf: Shelf) -> Mended:
    """Repair all parts that were cut off; raises `StateError` if the folder cannot be read.

    A part that any server is writing is locked and stays untouched.
    """
    mended = Mended()
    for part in shelf.parts():
        if part.events is None:
            continue
        try:
            if ending_of(part.events) == "cut" and _repair_part(part, part.events, mended.problems):
                mended.parts.append(part.name)
        except FileNotFoundError:  # deleted meanwhile
            continue
        except (OSError, StateError) as error:
            mended.problems.append(f"{part.name}: {reason_of(error)}")
    return mended


def _repair_part(part: Shelved, events: Path, problems: list[str]) -> bool:
    """Finish the files of a part, its events last; return False if there was nothing to do."""
    with events.open("r+b") as file:
        if not _has_locked(file):
            return False
        if ending_of(events) != "open":  # another program was faster
            return False
        status = os.fstat(file.fileno())
        media = () if part.media is None else (part.media,)
        for path in (*media, *part.cameras.values()):
            try:
                finish_media(path, is_there=events.exists)
            except StateError as error:
                problems.append(str(error))
        finish(file, round(part.began_s * 1e9))
        file.flush()
        os.fsync(file.fileno())
        # The file's time says when the part ended, and so when it expires.
        os.utime(file.fileno(), ns=(status.st_atime_ns, status.st_mtime_ns))
    return True


def _has_locked(file: IO[bytes]) -> bool:
    """Wait for those who only look how a file ends; return False if a program writes it."""
    while True:
        try:
            lock(file)
        except BlockingIOError:
            try:
                lock(file, shared=True)
            except OSError:
                return False
            time.sleep(_LOOK_S)
        except OSError:
            return False
        else:
            return True


def repair_beside(folder: Path) -> None:
    """Start a process that repairs the folder if any part was cut off; return at once."""
    threading.Thread(target=_run_repair, args=(folder,), name="tape repair", daemon=True).start()


def _run_repair(folder: Path) -> None:
    try:
        if not any(_is_cut(one) for one in Shelf(folder).parts()):
            return
        answer = python_module.ask(_MODULE, os.fsencode(folder), _WITHIN_S)
    except (OSError, StateError, subprocess.TimeoutExpired) as error:
        _LOG.warning("what was cut off the tape is not mended", why=reason_of(error))
        return
    for line in answer.stdout.decode(errors="replace").splitlines():
        _LOG.info("the tape was cut off when a server ended", part=line)
    if answer.returncode:
        _LOG.warning("what was cut off the tape is not mended", status=answer.returncode)


def _is_cut(part: Shelved) -> bool:
    with suppress(OSError):
        return part.events is not None and ending_of(part.events) == "cut"
    return False


def main() -> int:
    """Repair the folder named on standard input, at the lowest priority."""
    lower_priority()
    mended = repair(Shelf(Path(os.fsdecode(sys.stdin.buffer.read()))))
    lines = [*(f"{name}: is mended" for name in mended.parts), *mended.problems]
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
