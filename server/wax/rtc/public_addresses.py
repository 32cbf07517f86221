"""The public addresses that viewers are offered: configured ones, and what STUN servers see.

A household's address changes at its provider's whim, so the servers are asked repeatedly. The
result expires when this machine loses the local address it was seen for, as in another Wi-Fi.
"""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Final

import structlog

from wax.daemon_call import daemon_call
from wax.rtc.local_addresses import is_ours
from wax.rtc.stun_query import StunAnswer, StunError, ask

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

_LOG = structlog.get_logger(__name__)

_EVERY_S: Final = 300.0
_RETRY_S: Final = 30.0
"""Retry interval while no server answers."""
_CHECK_S: Final = 2.0
"""How often to check whether this machine still has that local address."""


class PublicAddresses:
    """The `fixed` addresses, and the one seen by the first of `servers` that answers.

    `ask` blocks, and raises `StunError`. `is_ours` tells whether this machine has an address now.
    """

    def __init__(
        self,
        fixed: Sequence[str],
        servers: Sequence[str],
        ask: Callable[[str], StunAnswer] = ask,
        is_ours: Callable[[str], bool] = is_ours,
    ) -> None:
        self._fixed = fixed
        self._servers = servers
        self._ask = ask
        self._is_ours = is_ours
        self._seen: StunAnswer | None = None
        self._problem: str | None = None

    def now(self) -> list[str]:
        """Return the addresses, without duplicates."""
        seen = [] if self._seen is None or self._has_moved else [self._seen.public]
        return list(dict.fromkeys([*self._fixed, *seen]))

    async def run(self) -> None:
        """Keep the addresses up to date until cancelled."""
        if not self._servers:
            await asyncio.Event().wait()
        while True:
            is_known = await self.refresh()
            for _ in range(round((_EVERY_S if is_known else _RETRY_S) / _CHECK_S)):
                await asyncio.sleep(_CHECK_S)
                if self._has_moved:
                    break

    async def refresh(self) -> bool:
        """Ask each server until one answers; if none does, keep this network's last result."""
        if self._has_moved:
            self._seen = None
        problem = ""
        for server in self._servers:
            try:
                seen = await daemon_call(
                    "ask STUN", partial(self._ask, server.removeprefix("stun:"))
                )
            except StunError as error:
                problem = str(error)
                continue
            if self._seen is None or seen.public != self._seen.public:
                _LOG.info("viewers elsewhere are offered the public address", address=seen.public)
            self._seen, self._problem = seen, None
            return True
        if problem != self._problem:
            _LOG.warning("the public address is unknown", why=problem)
            self._problem = problem
        return False

    @property
    def _has_moved(self) -> bool:
        return self._seen is not None and not self._is_ours(self._seen.own)
