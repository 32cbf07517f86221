"""The public addresses that viewers are offered: configured ones, and what STUN servers see.

A household's address changes with its provider's whims, so it is asked for again.
"""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING, Final

import structlog

from wax.rtc.stun_query import StunError, public_address

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

_LOG = structlog.get_logger(__name__)

_EVERY_S: Final = 300.0
_AGAIN_S: Final = 30.0
"""After no server has answered."""


class PublicAddresses:
    """`fixed` addresses, and the one that the first of `servers` that answers sees.

    `ask` blocks, and raises `StunError`.
    """

    def __init__(
        self,
        fixed: Sequence[str],
        servers: Sequence[str],
        ask: Callable[[str], str] = public_address,
    ) -> None:
        self._fixed = fixed
        self._servers = servers
        self._ask = ask
        self._seen: str | None = None
        self._problem: str | None = None

    def now(self) -> list[str]:
        """Return the addresses, without repetition."""
        return list(dict.fromkeys([*self._fixed, *([self._seen] if self._seen else [])]))

    async def run(self) -> None:
        """Keep them up to date until cancelled."""
        if not self._servers:
            await asyncio.Event().wait()
        while True:
            is_known = await self.look()
            await asyncio.sleep(_EVERY_S if is_known else _AGAIN_S)

    async def look(self) -> bool:
        """Ask until one answers; what was seen before stays otherwise."""
        problem = ""
        for server in self._servers:
            try:
                seen = await self._in_thread(server.removeprefix("stun:"))
            except StunError as error:
                problem = str(error)
                continue
            if seen != self._seen:
                _LOG.info("viewers elsewhere are offered the public address", address=seen)
            self._seen, self._problem = seen, None
            return True
        if problem != self._problem:
            _LOG.warning("the public address is unknown", why=problem)
            self._problem = problem
        return False

    async def _in_thread(self, server: str) -> str:
        """Ask without blocking; a name server that hangs does not delay the end of the process."""
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[str] = loop.create_future()

        def ask() -> None:
            try:
                found: str | StunError = self._ask(server)
            except StunError as error:
                found = error
            if not loop.is_closed():
                loop.call_soon_threadsafe(tell, found)

        def tell(found: str | StunError) -> None:
            if answer.done():
                return
            if isinstance(found, StunError):
                answer.set_exception(found)
            else:
                answer.set_result(found)

        threading.Thread(target=ask, name="ask STUN", daemon=True).start()
        return await answer
