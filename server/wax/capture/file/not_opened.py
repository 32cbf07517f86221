"""Why a stream does not open, or plays no longer: FFmpeg's errors say little, or something else."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from av.error import ExitError, HTTPError

from wax.errors import reason_of
from wax.second_look import explained
from wax.sentence import Sentence, says
from wax.unreachable import CLOSED, says_enough

if TYPE_CHECKING:
    from av.error import FFmpegError

    from wax.unreachable import Target

_TAKEN: Final = (CLOSED, "unreachable.hangs", "unreachable.nobody", "unreachable.no_connection")
"""How a camera that serves one client at a time turns away the next."""


def not_opened(name: str, target: Target | None, error: Exception, *, is_late: bool) -> Sentence:
    """Return why an address does not open; `name` is what is shown of it.

    Blocks for a second look at its `target` where the error says too little, as all do that come
    when `is_late`. What is not reached by TCP has no target.
    """
    if target is None and is_late:
        return Sentence("file.silent", {"name": name})
    if target is None or isinstance(error, HTTPError):
        why, is_taken = says(f"{reason_of(error)}."), target is not None
    else:
        plain = TimeoutError() if is_late else _plain(error)
        why = explained(target, plain)
        is_taken = why.code in _TAKEN
    if is_taken:
        return Sentence("file.perhaps_taken", {"name": name, "why": why})
    return Sentence("file.not_reached", {"name": name, "why": why})


def stopped(name: str, error: FFmpegError) -> Sentence:
    """Return why what has played plays no longer."""
    if isinstance(error, ExitError):
        return Sentence("file.silent", {"name": name})
    return Sentence("file.stopped", {"name": name, "why": reason_of(error)})


def _plain(error: Exception) -> Exception:
    """Return an error as sockets have it; what FFmpeg calls by another name is an end."""
    is_clear = isinstance(error, OSError) and says_enough(error)
    return error if is_clear else ConnectionAbortedError()
