"""Tunes memory: no long garbage collections, no heaps that only grow."""

from __future__ import annotations

import asyncio
import ctypes
import gc
from asyncio import selector_events, sslproto
from typing import Final

_GC_THRESHOLDS: Final = (700, 10, 20_000)
"""Python's defaults, but a full collection only after 20,000 of `run`'s, half an hour: one blocked
the event loop for 35 ms while a crowd joined. Viewers who have left need none, since their cycles
are broken (`wax.weak_callback`, `break_circle`, `private.break_cycles`)."""
_COLLECT_S: Final = 0.1
_COLLECTIONS_PER_TRIM: Final = 50
_M_TRIM_THRESHOLD: Final = -1
_M_MMAP_THRESHOLD: Final = -3
"""From glibc's malloc.h."""
_LARGE_OCTETS: Final = 4 * 1024 * 1024
"""Above a raw picture of 1920×1080, several of which are allocated for each frame: fresh pages for
one of 1280×720 take up to 2 ms."""
_READ_OCTETS: Final = 32 * 1024
_TLS_READ_OCTETS: Final = 2048
"""By itself, asyncio allocates 256 KiB for each read, and keeps as much for each TLS connection.
What TLS reads at once may be anything but HTTP, such as 75 new keys, each of which takes it 25 µs.
"""


def settle() -> None:
    """Call once, when everything permanent is loaded."""
    # Unless frozen, it is scanned in each full collection: in a flood of offers, that blocks the
    # event loop for a tenth of a second each time.
    gc.collect()
    gc.freeze()
    gc.set_threshold(*_GC_THRESHOLDS)
    return_large_blocks()
    read_in_small_pieces()


async def run() -> None:
    """Collect garbage often and briefly, and return free memory, until cancelled.

    By itself, Python collects once there are 700 more objects. Where old ones go as new ones come,
    as in the histories of a crowd's links, that takes seconds; scanning all the new ones then
    blocked the event loop for up to 16 ms with fifty viewers.
    """
    while True:
        for _ in range(_COLLECTIONS_PER_TRIM):
            await asyncio.sleep(_COLLECT_S)
            collect_young()
        await asyncio.to_thread(give_back)


def collect_young() -> None:
    """Collect the young generations; the objects that survive are then old."""
    gc.collect(1)


def give_back() -> None:
    """Have the C library return all free pages of its heaps to the system: malloc_trim(3).

    By itself, glibc returns only the end of a heap, and hundreds of connections leave holes. This
    takes half a millisecond, or 4 after a burst of 20 MiB, so call it outside the event loop.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def return_large_blocks() -> None:
    """Have the C library map each large block separately, and unmap it when it is freed.

    By itself, glibc allocates ever larger blocks from each thread's heap, where a small block
    behind one keeps it from being returned: mallopt(3). With another C library, this does nothing.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _LARGE_OCTETS)
        mallopt(_M_TRIM_THRESHOLD, _LARGE_OCTETS)  # it has grown with the largest block so far


def read_in_small_pieces() -> None:
    """Have asyncio take no more memory for each connection than what comes at once."""
    transport = selector_events._SelectorSocketTransport  # type: ignore[attr-defined]
    transport.max_size = _READ_OCTETS
    sslproto.SSLProtocol.max_size = _TLS_READ_OCTETS


def break_circle(transport: asyncio.BaseTransport) -> None:
    """Break a closed transport's reference cycles, so that its memory is free at once.

    asyncio's transports hold their own bound methods, and strangers open thousands in a minute.
    """
    held = vars(transport)
    for name in [name for name, one in held.items() if getattr(one, "__self__", None) is transport]:
        del held[name]
