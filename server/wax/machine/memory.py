"""How the process keeps memory: no long searches for garbage, no heaps that only grow."""

from __future__ import annotations

import asyncio
import ctypes
import gc
from asyncio import selector_events, sslproto
from typing import Final

_GC_THRESHOLDS: Final = (700, 10, 20_000)
"""As usual, but full collections after 20,000 looks, half an hour: one stopped the event loop for
35 ms while a crowd joined, and who is gone needs none (`wax.weak_callback`, `break_circle`,
`private.break_circles`)."""
_LOOK_S: Final = 0.1
_LOOKS_UNTIL_GIVEN_BACK: Final = 50
_M_TRIM_THRESHOLD: Final = -1
_M_MMAP_THRESHOLD: Final = -3
"""As in glibc's malloc.h."""
_LARGE_OCTETS: Final = 512 * 1024
"""Above a raw picture of 640×480, which comes and goes with each frame and is kept; below what an
encoder holds."""
_READ_OCTETS: Final = 32 * 1024
"""By itself asyncio takes 256 KiB for each read, and keeps as much for each connection by TLS."""


def settle() -> None:
    """Call once, when everything that stays is loaded."""
    # To look through it again and again in a flood of offers stops the event loop for a tenth of a
    # second each time.
    gc.collect()
    gc.freeze()
    gc.set_threshold(*_GC_THRESHOLDS)
    return_large_blocks()
    read_in_small_pieces()


async def run() -> None:
    """Look for garbage often and briefly, and give back what is free, until cancelled.

    By itself Python looks when objects have become 700 more. Where old ones go as new ones come, as
    in the histories of a crowd's links, they do not for seconds; all new ones are looked through
    then, which stopped the event loop for up to 16 ms beside fifty viewers.
    """
    while True:
        for _ in range(_LOOKS_UNTIL_GIVEN_BACK):
            await asyncio.sleep(_LOOK_S)
            look()
        await asyncio.to_thread(give_back)


def look() -> None:
    """Look for garbage among what is new; whatever stays is not new any more."""
    gc.collect(1)


def give_back() -> None:
    """Have the C library give back all pages of its heaps that are free: malloc_trim(3).

    By itself glibc gives back the end of a heap, and hundreds of connections leave holes. It takes
    half a millisecond, or 4 after a burst of 20 MiB, so call it beside the event loop.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def return_large_blocks() -> None:
    """Have the C library map each large block by itself, and unmap it when it is freed.

    By itself glibc takes ever larger ones from the heap of each thread, where a small one behind
    them holds them: mallopt(3). Nothing happens with another C library.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _LARGE_OCTETS)
        mallopt(_M_TRIM_THRESHOLD, _LARGE_OCTETS)  # has grown with the largest block so far


def read_in_small_pieces() -> None:
    """Have asyncio take no more memory for each connection than what comes at once."""
    transport = selector_events._SelectorSocketTransport  # type: ignore[attr-defined]
    for kind in (transport, sslproto.SSLProtocol):
        kind.max_size = _READ_OCTETS


def break_circle(transport: asyncio.BaseTransport) -> None:
    """Let go of a closed transport, so that its memory is free at once.

    asyncio's hold bound methods of their own, and strangers make thousands of them in a minute.
    """
    held = vars(transport)
    for name in [name for name, one in held.items() if getattr(one, "__self__", None) is transport]:
        del held[name]
