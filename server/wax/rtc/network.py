"""How this server's peers reach the network: the one port for everybody, or full ICE."""

from __future__ import annotations

import asyncio
import secrets
from typing import TYPE_CHECKING, Final

from aiortc import RTCCertificate, RTCConfiguration, RTCIceServer, RTCIceTransportPolicy

from wax.daemon_call import daemon_call
from wax.edge.budget import Budget, Rates
from wax.edge.turnstile import Meter
from wax.rtc import private
from wax.rtc.local_addresses import local_addresses
from wax.rtc.one_port.lite_connection import LiteConnection
from wax.rtc.one_port.udp_hub import UdpHub
from wax.rtc.public_addresses import PublicAddresses

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

    from wax.clock import Clock
    from wax.config.network import NetworkSettings
    from wax.edge.turnstile import Turnstile
    from wax.rtc.ice_servers import IceServers

_OURS: Final = "server"
"""Prefix of our own relays' TURN user names, one for each because servers limit relays per name."""
_GUESTS: Final = Rates(committed=0.01, committed_burst_s=0.02, pool=0.15, pool_burst_s=0.1)
"""A viewer's datagrams cost 0.3 % of a core; connecting costs some 10 ms once."""
_TRUSTED: Final = Rates(committed=0.3, committed_burst_s=0.3, pool=0.0, pool_burst_s=0.0)
"""For one operator or host, who needs a hundredth of it; it must leave room for a Stop."""
_CERTIFICATE_S: Final = 86_400.0
"""All peers of a day share a certificate: making one takes a millisecond, and it tells a viewer no
more than our address does. It is valid for 30 days."""


class Network:
    """Owned by the composition root: opened before the first peer, closed after the last."""

    def __init__(
        self,
        settings: NetworkSettings,
        servers: IceServers,
        clock: Clock,
        turnstile: Turnstile,
    ) -> None:
        self._settings = settings
        self._servers = servers
        self._clock = clock
        self._turnstile = turnstile
        self._guests = Budget(_GUESTS)
        self._certificate = RTCCertificate.generateCertificate()
        self._hub = UdpHub(settings.udp_port, self._addresses)
        self._public = PublicAddresses(
            settings.public_addresses, settings.stun if settings.mode == "one-port" else []
        )

    @property
    def udp_port(self) -> int | None:
        """The one port; None with full ICE, or before `open` if any free port will do."""
        return (self._hub.port or None) if self._settings.mode == "one-port" else None

    async def open(self) -> None:
        """Bind the one port; raises `StartError`."""
        if self._settings.mode == "one-port":
            await self._hub.open()

    async def run(self) -> None:
        """Keep the public addresses and the certificate up to date until cancelled."""
        async with asyncio.TaskGroup() as group:
            group.create_task(self._public.run())
            group.create_task(self._renew_certificate())

    async def _renew_certificate(self) -> None:
        while True:
            await asyncio.sleep(_CERTIFICATE_S)
            self._certificate = await daemon_call("certificate", RTCCertificate.generateCertificate)

    def public_addresses(self) -> list[str]:
        """Return the known public addresses of this machine."""
        return self._public.now()

    def close(self) -> None:
        """Close the one port; safe to call twice."""
        self._hub.close()

    def meter(self, address: str, is_trusted: Callable[[], bool]) -> Meter:
        """Return the meter that charges a peer at this address."""
        trusted = Budget(_TRUSTED).payer(address)
        return Meter(self._turnstile, self._guests.payer(address), trusted, is_trusted)

    def reached(self, meter: Meter, on_moved: Callable[[], None]) -> AbstractContextManager[None]:
        """Let peers made and answered inside reach this network (`private.reached_by`).

        `on_moved` is called when the browser continues from another address.
        """

        def connect() -> LiteConnection:
            now_s = self._clock.now_s
            return LiteConnection(self._hub, self._public.now, now_s, meter, on_moved)

        is_one = self._settings.mode == "one-port"
        reach = private.Reach(connect if is_one else None, self._addresses, self._certificate)
        return private.reached_by(reach)

    def configuration(self) -> RTCConfiguration:
        """Return the configuration of one of our peers.

        With the one port, peers ask no ICE server. The list is then empty rather than None: with
        None aiortc would ask a public STUN server.
        """
        if self._settings.mode == "one-port":
            return RTCConfiguration(iceServers=[])
        told = self._servers.for_viewer(
            f"{_OURS}-{secrets.token_hex(4)}", self._clock.wall_ms() / 1000
        )
        policy = RTCIceTransportPolicy.RELAY if self._servers.relay_only else None
        return RTCConfiguration(
            iceServers=[RTCIceServer(**one) for one in told],
            iceTransportPolicy=policy or RTCIceTransportPolicy.ALL,
        )

    def _addresses(self) -> list[str]:
        return local_addresses(self._settings.interfaces)
