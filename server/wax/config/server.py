"""`[server]`: where the page is served, and to how many."""

from __future__ import annotations

from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import Field, model_validator

from wax.config.addresses import ONE_HOST, HostName, Network, PageUrl
from wax.config.table import ConfigTable


class ServerSettings(ConfigTable):
    """Where the page is served, and to how many viewers."""

    host: Annotated[str, Field(min_length=1), ONE_HOST] = "localhost"
    """The name or address on which the page is served. "localhost" lets only this machine in,
    "0.0.0.0" every device on the network."""
    port: Annotated[int, Field(ge=0, le=65535)] = 8080
    """The TCP port of the page; 0 picks a free one and prints it."""
    max_viewers: Annotated[int, Field(ge=1, le=1000)] = 100
    """How many browsers may watch at once; more are refused, as are newcomers while the machine is
    too busy to drive on time. Each costs the machine a little CPU time, and its upload the bit rate
    of one rendition."""
    state_dir: str = ""
    """The folder for what outlives the server, readable by its user only: the records, its secrets,
    a Stop in force, and what you have closed, switched off or limited. Give each robot's server
    its own: of two in one folder the second keeps no Stop over a restart, and its host is told.
    "" is systemd's StateDirectory, else $XDG_STATE_HOME/wax, else ~/.local/state/wax."""
    max_share_per_address: Annotated[float, Field(gt=0, le=1)] = 0.5
    """The largest share of max_viewers that viewers from one address (IPv6: one /64 network) may
    take together, at least four. The host is not counted. 1 lets a school that is behind one
    address take all places."""
    max_offers_per_address_hz: Annotated[float, Field(gt=0, le=1000)] = 2.0
    """How many times a second browsers of one address may connect, in the long run; twenty times as
    many at once, as when a class opens the page together."""
    max_silent_per_address: Annotated[int, Field(ge=1, le=1000)] = 2
    """How many browsers of one address may be connecting at once; the others wait, and then connect
    by themselves. Those that have connected do not count."""
    names: list[HostName] = []
    """The names, and addresses of a router in front, by which browsers may reach this server. This
    machine's own names and addresses and "localhost" always count; for any other a request is
    refused, so that no website can pretend to be this server (DNS rebinding). An international
    name may be written in its own letters.

    Example: names = ["robot.example.org", "203.0.113.7"]
    """
    public_url: PageUrl = ""
    """The page's address for people elsewhere, where it is not what the host's own browser shows:
    behind a router that forwards a port, or below a proxy's path. Invitations and previews of
    links get it. Its name counts as one of names.

    Example: public_url = "http://203.0.113.7:8080"
    """
    trusted_proxies: list[Network] = []
    """Proxies in front of this server, by address or network, that are believed when they say for
    whom they ask, and how (X-Forwarded-For, -Proto and -Host, or Forwarded). A proxy must set
    one of these and drop the other: where both come and name different senders, the request is
    refused. From anybody else they are ignored. Without this, everybody behind a proxy shares
    one address's limits.

    Example: trusted_proxies = ["127.0.0.1", "::1"]
    """
    https: bool = False
    """Whether to serve HTTPS only, with a self-signed certificate that is made here and kept. Each
    browser asks once whether to trust it; compare its fingerprint with the one on the terminal.
    Also --https."""
    certificate: str = ""
    """The file of your own certificate and its chain, in PEM form; with it only HTTPS is served,
    and key is needed. New files are read as soon as they have changed. Empty: none."""
    key: str = ""
    """The private key of that certificate, as a file in PEM form, without a password."""
    max_connections: Annotated[int, Field(ge=16, le=100_000)] = 640
    """How many HTTP connections may be open at once, in all: if more come, one is closed, of the
    address that has most. Where the system lets the server open too few files, it has as many as
    fit, and says so in its log; `wax doctor` does, too."""
    max_connections_per_address: Annotated[int, Field(ge=4, le=100_000)] = 64
    """How many HTTP connections may be open from one address (IPv6: one /64 network). A trusted
    proxy's own are not limited, but each counts for the address for which it asks. A browser opens
    up to six."""

    @property
    def all_names(self) -> list[str]:
        """`names`, and that of the public page."""
        public = urlsplit(self.public_url).hostname
        return [*self.names, *([public] if public else [])]

    @model_validator(mode="after")
    def _certificate_has_its_key(self) -> Self:
        if bool(self.certificate) != bool(self.key):
            missing = "key" if self.certificate else "certificate"
            raise ValueError(f"certificate and key belong together; {missing} is missing")
        return self
