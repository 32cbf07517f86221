"""The suite's operator: the protocol's client, at full speed, optionally through a relay."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.client import Operator
from wax.client.operator import PERIOD_S, Sent
from wax.rtc import private

if TYPE_CHECKING:
    from e2e.faults.relay import Relay
    from e2e.harness.server import Server

__all__ = ["PERIOD_S", "RawOperator", "Sent"]

_ELSEWHERE: Final = {"X-Forwarded-For": "192.0.2.1"}
"""Only a viewer on another machine can be refused a release (documentation address)."""


class RawOperator(Operator):
    """`relay` is its network; with None it has the loopback."""

    def __init__(
        self,
        server: Server,
        *,
        client: str | None = None,
        relay: Relay | None = None,
        is_host: bool = False,
        sees: bool = False,
    ) -> None:
        private.install()  # a browser stays on a slow link, too, which aioice alone leaves
        super().__init__(
            server.url,
            client_id=client,
            route=relay,
            headers={} if is_host else _ELSEWHERE,
            sees=sees,
        )
