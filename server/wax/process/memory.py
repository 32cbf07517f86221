"""How the process keeps memory: no long searches for garbage, no heaps that only grow."""

from __future__ import annotations

import ctypes
import gc
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import asyncio

_GC_THRESHOLDS: Final = (700, 10, 1000)
"""As usual, but full collections a hundred times less often: one stopped the event loop for 35 ms
while a crowd joined, and who is gone needs none (`wax.weak_callback`, `break_circle`,
`private.break_circles`)."""
_M_TRIM_THRESHOLD: Final = -1
_M_MMAP_THRESHOLD: Final = -3
"""As in glibc's malloc.h."""
_LARGE_OCTETS: Final = 512 * 1024
"""Above a raw picture of 640×480, which comes and goes with each frame and is kept; below what an
encoder holds."""


def settle() -> None:
    """Call once, when everything that stays is loaded."""
    # To look through it again and again in a flood of offers stops the event loop for a tenth of a
    # second each time.
    gc.collect()
    gc.freeze()
    gc.set_threshold(*_GC_THRESHOLDS)
    return_large_blocks()


def return_large_blocks() -> None:
    """Have the C library map each large block by itself, and unmap it when it is freed.

    By itself glibc takes ever larger ones from the heap of each thread, where a small one behind
    them holds them: mallopt(3). Nothing happens with another C library.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _LARGE_OCTETS)
        mallopt(_M_TRIM_THRESHOLD, _LARGE_OCTETS)  # has grown with the largest block so far


def break_circle(transport: asyncio.BaseTransport) -> None:
    """Let go of a closed transport, so that its memory is free at once.

    asyncio's hold bound methods of their own, and strangers make thousands of them in a minute.
    """
    held = vars(transport)
    for name in [name for name, one in held.items() if getattr(one, "__self__", None) is transport]:
        del held[name]
