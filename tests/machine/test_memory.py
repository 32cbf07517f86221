"""Whether freed memory is returned to the system, and how garbage is collected."""

from __future__ import annotations

import asyncio
import ctypes
import gc
import ssl
import subprocess
import sys
import threading
from asyncio import selector_events, sslproto
from collections import deque

import pytest
from tests.until import async_until

from wax.machine import memory

CAME_AND_WENT = """
import ctypes, psutil
from wax.machine.memory import give_back, return_large_blocks

if {returns}:
    return_large_blocks()
c = ctypes.CDLL(None)
c.malloc.restype, c.free.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
c.memset.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_size_t]
mib = 2**20
c.free(c.malloc(16 * mib))
before = psutil.Process().memory_info().rss
large, small = [], []
for _ in range(64 * mib // {size}):
    large.append(c.malloc({size}))
    small.append(c.malloc(200_000))  # no gap of an import holds all of these
    c.memset(large[-1], 1, {size})
for one in large:
    c.free(one)
if {gives}:
    give_back()
print((psutil.Process().memory_info().rss - before) // mib)
"""


@pytest.mark.skipif(
    not hasattr(ctypes.CDLL(None), "gnu_get_libc_version"), reason="another C library than glibc"
)
@pytest.mark.parametrize(
    ("size", "does", "kept_mib"),
    [
        (2**23, "returns", range(4)),
        (2**23, "", range(60, 68)),
        (2**16, "gives", range(12)),
        (2**16, "returns", range(60, 72)),  # a page of each of the 1,024 small ones is 4 MiB
    ],
)
def test_blocks_that_came_and_went_are_given_back(size: int, does: str, kept_mib: range) -> None:
    """Freed blocks are returned even with small ones behind them, unlike glibc by default."""
    script = CAME_AND_WENT.format(size=size, returns=does == "returns", gives=does == "gives")
    told = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=20
    )
    assert int(told.stdout) in kept_mib


async def test_no_connection_keeps_more_than_comes_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By TLS each has a buffer as large as its largest read: by asyncio 640 have 160 MiB."""
    transport: type = selector_events._SelectorSocketTransport  # type: ignore[attr-defined]
    for kind in (transport, sslproto.SSLProtocol):
        monkeypatch.setattr(kind, "max_size", 262_144)
    memory.read_in_small_pieces()
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    loop, inner = asyncio.get_running_loop(), asyncio.Protocol()
    kept = sslproto.SSLProtocol(loop, inner, context, None, server_side=True)  # type: ignore[arg-type]
    assert len(kept.get_buffer(-1)) == 2048
    kept._get_app_transport().abort()  # type: ignore[attr-defined]
    assert transport.max_size == 32_768  # type: ignore[attr-defined]


async def test_what_is_free_is_given_back_beside_the_event_loop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Free memory is returned within seconds, in another thread, since it may take milliseconds."""
    given: list[int] = []
    monkeypatch.setattr(memory, "_COLLECT_S", 0.0)
    monkeypatch.setattr(memory, "give_back", lambda: given.append(threading.get_ident()))
    running = asyncio.create_task(memory.run())
    await async_until(lambda: len(given) >= 2)
    running.cancel()
    assert threading.get_ident() not in given


def test_what_stays_is_looked_through_once() -> None:
    """Histories whose entries come and go do not pile up as young objects for a long collection."""
    history = deque(([number] for number in range(20_000)), maxlen=20_000)
    for number in range(20_000):
        history.append([number])
    assert _new_objects() > 15_000  # Python by itself has not collected
    memory.collect_young()
    assert _new_objects() < 1000


def _new_objects() -> int:
    return sum(len(gc.get_objects(generation)) for generation in (0, 1))
