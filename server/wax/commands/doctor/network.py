"""The part of the configuration that decides what the world can reach."""

from __future__ import annotations

import contextlib
import ipaddress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax import state_dir
from wax.errors import StateError
from wax.web.certificate import Certificate, kept_in

if TYPE_CHECKING:
    from wax.config.server import ServerSettings
    from wax.config.settings import Settings

_EVERYWHERE: Final = ("", "0.0.0.0", "::")


@dataclass(frozen=True, slots=True)
class ServedNetwork:
    """Where the page is served, and how picture, sound and commands travel.

    `udp_port` is None if each viewer gets a random port. `certificate` is None for plain HTTP; with
    `is_self_signed` the server creates it. `stun` has servers as ``HOST:PORT``. Behind a proxy,
    viewers reach the page through the proxy and its port. `interfaces` are those used for media,
    all if empty.
    """

    host: str
    tcp_port: int
    udp_port: int | None
    interfaces: tuple[str, ...]
    public_addresses: tuple[str, ...]
    stun: tuple[str, ...]
    certificate: Certificate | None
    is_self_signed: bool
    is_behind_proxy: bool
    names: tuple[str, ...]
    door: str = ""

    @property
    def is_local(self) -> bool:
        """Whether the page is served to this machine only, of which a proxy may be part."""
        if self.host in _EVERYWHERE:
            return False
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return self.host == "localhost"

    @property
    def is_everywhere(self) -> bool:
        """Whether the page is served at every address of this machine."""
        return self.host in _EVERYWHERE

    @property
    def ports(self) -> str:
        """The ports that a firewall or router must let in, in words."""
        udp = "" if self.udp_port is None else f" and UDP port {self.udp_port}"
        tcp = 443 if self.is_behind_proxy else self.tcp_port
        return f"TCP port {tcp}{udp}"


def network_of(settings: Settings, stun: str | None = None) -> ServedNetwork:
    """Read the configuration; `stun`, as ``HOST:PORT``, replaces its STUN servers."""
    server, network = settings.server, settings.network
    configured = [url.removeprefix("stun:") for url in network.stun]
    return ServedNetwork(
        host=server.host,
        tcp_port=server.port,
        udp_port=network.udp_port if network.mode == "one-port" else None,
        interfaces=tuple(network.interfaces),
        public_addresses=tuple(network.public_addresses),
        stun=tuple([stun] if stun else configured),
        certificate=_certificate(server),
        is_self_signed=server.https and not server.certificate,
        is_behind_proxy=bool(server.trusted_proxies),
        names=tuple(server.all_names),
        door=settings.door.host,
    )


def _certificate(server: ServerSettings) -> Certificate | None:
    if server.certificate:
        return Certificate(Path(server.certificate), Path(server.key))
    with contextlib.suppress(StateError):
        return kept_in(state_dir.find(server.state_dir)) if server.https else None
    return None
