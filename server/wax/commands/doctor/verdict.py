"""A check's verdict, and how a check is run: in a thread, with a time limit, alone."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from wax.errors import WaxError, reason_of

if TYPE_CHECKING:
    from collections.abc import Callable

Level = Literal["ok", "warning", "bad"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was found, as a sentence; where it is not ok, `advice` says what to do."""

    level: Level
    sentence: str
    advice: str = ""


def ok(sentence: str) -> Verdict:
    return Verdict("ok", sentence)


def warning(sentence: str, advice: str) -> Verdict:
    return Verdict("warning", sentence, advice)


def bad(sentence: str, advice: str) -> Verdict:
    return Verdict("bad", sentence, advice)


@dataclass(frozen=True, slots=True)
class Check:
    """One check; `look` may block for `limit_s` and may raise anything."""

    name: str
    look: Callable[[], Verdict]
    limit_s: float = 5.0


def examine(check: Check) -> Verdict:
    """Run a check and return its verdict; an exception or a timeout becomes a bad one."""
    found: list[Verdict] = []

    def look() -> None:
        try:
            found.append(check.look())
        except WaxError as error:
            found.append(bad(f"{error}", "Correct what it names, then try once more."))
        except Exception as error:
            reason = reason_of(error)
            found.append(bad(f"The check failed: {reason}.", "Report this with its text."))

    # A daemon: a device that hangs in its operating system driver must not keep the process alive.
    thread = threading.Thread(target=look, name=check.name, daemon=True)
    thread.start()
    thread.join(check.limit_s)
    if found:
        return found[0]
    return bad(
        f"No result within {check.limit_s:g} s.",
        "What was checked hangs: unplug it and plug it in again, then try once more.",
    )
