"""Explains why a stream does not open or has stopped: FFmpeg's errors are vague or misleading."""

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
"""How a camera that serves one client at a time may reject the next."""


def not_opened(name: str, target: Target | None, error: Exception, *, is_late: bool) -> Sentence:
    """Return why an address does not open; `name` is the part of it that people may see.

    Blocks while it probes `target` if the error is too vague, as every error is after a timeout
    (`is_late`). An address that is not reached by TCP has no target.
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
    """Return why a stream that was playing has stopped."""
    if isinstance(error, ExitError):
        return Sentence("file.silent", {"name": name})
    return Sentence("file.stopped", {"name": name, "why": reason_of(error)})


def _plain(error: Exception) -> Exception:
    """Return the error as a socket would raise it; a vague one counts as a closed connection."""
    is_clear = isinstance(error, OSError) and says_enough(error)
    return error if is_clear else ConnectionAbortedError()
