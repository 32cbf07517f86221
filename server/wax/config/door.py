"""`[door]`: the public machine that relays the page where no port can be forwarded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from wax.config.allowed import said
from wax.config.table import ConfigTable

if TYPE_CHECKING:
    from wax.config.server import ServerSettings

DoorHost = Annotated[
    str,
    Field(pattern=r"^([A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?)?$"),
    said('empty, or a host name or address, as "robot.example.org"'),
]
HostKey = Annotated[
    str,
    Field(pattern=r"^(ssh-ed25519 AAAAC3NzaC1lZDI1NTE5[A-Za-z0-9+/]{48})?$"),
    said('empty, or a key as "ssh-ed25519 AAAA…"'),
]


class DoorSettings(ConfigTable):
    """A public machine of yours through which people reach the page where no port can be opened
    here: this server keeps an SSH connection to it, by TCP 22 or, where that is closed, by
    HTTPS. Picture, sound and commands go past it, or by its relay. config/deploy/door.sh sets it
    up and prints a line from which `wax init --door LINE` writes this table and what [server],
    [network] and [relay] need.
    """

    host: DoorHost = ""
    """The machine's name, by which people reach the robot, too."""
    port: Annotated[int, Field(ge=0, le=65535)] = 0
    """The TCP port on that machine, open to nobody outside, that leads to this robot."""
    host_key: HostKey = ""
    """The SSH host key of that machine."""
    key_file: str = ""
    """The file with this robot's private key, which opens that port and nothing else."""

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        missing = [name for name in ("port", "host_key", "key_file") if not getattr(self, name)]
        if self.host and missing:
            raise ValueError(
                f"{' and '.join(missing)} missing; let `wax init --door LINE` write this table"
            )
        return self


def check_server(door: DoorSettings, server: ServerSettings) -> None:
    """Raise `ValueError` if the server's settings do not fit the door."""
    if not door.host:
        return
    if server.https or server.certificate:
        raise ValueError(
            "door: the door has the certificate and asks this machine by HTTP; leave https and"
            " certificate out of [server]"
        )
    if not server.trusted_proxies:
        raise ValueError(
            "door: all its visitors would share one address's limits; set [server]"
            ' trusted_proxies = ["127.0.0.1", "::1"]'
        )
