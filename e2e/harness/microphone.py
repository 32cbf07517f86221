"""A microphone that hears words, from our own sound server, for browsers without a fake one."""

from __future__ import annotations

import asyncio
import os
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.child import kill
from e2e.harness.speech import RATE_HZ

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.measure.ear import Ear

_COMMANDS: Final = (
    f"load-module module-null-sink sink_name=mouth rate={RATE_HZ} channels=1",
    # Browsers leave out sources that only repeat what a sink plays.
    "load-module module-remap-source master=mouth.monitor source_name=microphone",
    "set-default-source microphone",
    "set-default-sink ear",
)


@asynccontextmanager
async def hearing(ear: Ear, words: Path) -> AsyncIterator[None]:
    """Give programs that play to `ear` a microphone that hears the words of this WAV, once."""
    quiet: dict[str, Any] = {
        "env": {**os.environ, **ear.variables},
        "stdout": asyncio.subprocess.DEVNULL,
    }
    for command in _COMMANDS:
        asked = await asyncio.create_subprocess_exec("pactl", *command.split(), **quiet)
        assert await asked.wait() == 0, f"pactl {command} fails"
    mouth = await asyncio.create_subprocess_exec(
        *("paplay", "--device=mouth", "--latency-msec=50", str(words)), **quiet
    )
    try:
        yield
    finally:
        await kill(mouth)
