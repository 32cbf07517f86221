"""`wax hook test`: posts a sample to each hook and reports the answers."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final

from wax.errors import ConfigError
from wax.hooks.hooks import Hook
from wax.hooks.post import HookError, session
from wax.logs.printable import printable
from wax.protocol.events import HookTested

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.config.settings import Settings

_MOST_CHARS: Final = 200


async def hook_test(settings: Settings, clock: Clock, tell: Callable[[str], None]) -> int:
    """Return 0 if every hook accepted the sample, else 1.

    Raises `ConfigError` if there is no hook, and `StartError` if a secret cannot be read.
    """
    if not settings.hook:
        raise ConfigError("there is no [[hook]] to test; name a configuration with --config")
    hooks = [Hook(number, one, clock) for number, one in enumerate(settings.hook, 1)]
    now = datetime.fromtimestamp(clock.wall_ms() / 1000, UTC).isoformat(timespec="milliseconds")
    failed = False
    async with session(lambda: settings.server.port) as http:
        for hook in hooks:
            began_s = time.perf_counter()
            try:
                status, begins = await hook.post(
                    http, hook.message(HookTested(timestamp=now)), wants_answer=True
                )
            except HookError as error:
                failed = True
                tell(f"hook {hook.name}: not taken. {error}")
                continue
            took_ms = round((time.perf_counter() - began_s) * 1000)
            text = printable(begins.decode(errors="replace").strip(), _MOST_CHARS)
            said = f", and says: {text}" if text else ""
            tell(f"hook {hook.name}: taken within {took_ms} ms, with status {status}{said}")
    return int(failed)
