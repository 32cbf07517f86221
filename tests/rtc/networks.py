"""Ways in which a peer under test reaches the network."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Literal

from wax.clock import SystemClock
from wax.config.network import NetworkSettings
from wax.config.relay import RelaySettings
from wax.edge.budget import Budget, Rates
from wax.edge.turnstile import Meter, Turnstile
from wax.rtc.ice_servers import IceServers
from wax.rtc.network import Network

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from wax.clock import Clock

Mode = Literal["one-port", "full-ice"]


def network(mode: Mode = "full-ice", clock: Clock | None = None) -> Network:
    """Return a network that is not open yet; full ICE does not need it open."""
    settings = NetworkSettings(mode=mode, udp_port=0)
    clock = clock or SystemClock()
    return Network(settings, IceServers(settings, RelaySettings()), clock, Turnstile(clock))


def rich_meter() -> Meter:
    """Return a meter that is never over budget."""
    budget = Budget(Rates(committed=1.0, committed_burst_s=60.0, pool=0.0, pool_burst_s=0.0))
    return Meter(Turnstile(SystemClock()), budget.payer(""))


@asynccontextmanager
async def opened_network(mode: Mode = "one-port") -> AsyncIterator[Network]:
    """Open a network on any free port."""
    made = network(mode)
    await made.open()
    try:
        yield made
    finally:
        made.close()
