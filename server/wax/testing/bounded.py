"""Makes calls that may hang, so that the test fails instead of hanging."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

HANGS_S: Final = 10.0
_DESCRIPTORS: Final = Path("/proc/self/fd")


def took_s(call: Callable[[], object], at_most_s: float) -> float:
    """Call it in a thread of its own, which is left behind if it hangs; return how long it took.

    Raises `AssertionError` if it has not returned after `at_most_s`, and whatever the call raises.
    """
    raised: list[BaseException] = []

    def run() -> None:
        try:
            call()
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=run, name="bounded call", daemon=True)
    start_s = time.monotonic()
    thread.start()
    thread.join(at_most_s)
    assert not thread.is_alive(), (
        f"{getattr(call, '__qualname__', call)} has not returned after {at_most_s:g} s: do slow"
        " input and output in a thread of the driver's own"
    )
    if raised:
        raise raised[0]
    return time.monotonic() - start_s


def held() -> set[str]:
    """Return the threads, files, sockets and devices that this process has now."""
    found = {f"thread {thread.name} ({thread.ident})" for thread in threading.enumerate()}
    for entry in _DESCRIPTORS.iterdir() if _DESCRIPTORS.is_dir() else ():
        try:
            target = str(entry.readlink())
        except OSError:
            continue  # the descriptor that listed this folder
        if not target.startswith("/proc/"):
            found.add(f"{target} ({entry.name})")
    return found
