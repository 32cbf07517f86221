"""`[[hook]]`: the webhooks, their addresses and their events."""

from __future__ import annotations

import ipaddress
import re
from typing import TYPE_CHECKING, Annotated, Any, Final, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, model_validator

from wax.config import allowed, host_spelling
from wax.config.addresses import ONE_URL
from wax.config.table import ConfigTable
from wax.protocol.events import NAMES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

MAX_HOOKS: Final = 8

_ENDPOINT: Final = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[\w.-]+):(\d{1,5})(?![\w.:])")
_HERE: Final = "localhost"
_PORTS: Final = {"http": 80, "https": 443, "mqtt": 1883, "mqtts": 8883}


def _whole(url: str) -> str:
    if urlsplit(url).port == 0:  # raises ValueError for what is no port
        raise ValueError("Port 0 is none")
    return url


HookUrl = Annotated[
    str,
    Field(
        pattern=r"^https?://(\[[0-9A-Fa-f:.]+\]|[^\s/?#@:\[\]\\]+)(:\d{1,5})?([/?][^\s#]*)?$",
        max_length=2000,
        description='an address as "https://example.org/hook", without a user\'s name',
    ),
    ONE_URL,
    AfterValidator(_whole),
]


EventName = Annotated[
    str,
    Field(
        pattern=f"^({'|'.join(map(re.escape, NAMES))})$",
        description=allowed.words({"enum": list(NAMES)}),
    ),
]


class HookSettings(ConfigTable):
    """One webhook."""

    url: HookUrl
    events: Annotated[list[EventName], Field(max_length=len(NAMES))] = []
    secret_file: Annotated[str, Field(min_length=1)]
    ca_file: str = ""
    names: bool = False

    @model_validator(mode="after")
    def _encrypts(self) -> Self:
        if self.ca_file and not self.url.startswith("https:"):
            raise ValueError("ca_file is for an encrypted connection; write url as https://")
        return self

    @property
    def host(self) -> str:
        """The host of its URL, the only part to show: the path is often a secret."""
        return urlsplit(self.url).netloc


def check_targets(
    targets: Iterable[tuple[str, str]], own_port: int, own_names: Sequence[str], robot: object
) -> None:
    """Raise `ValueError` for a key whose URL leads to this server, or to the robot.

    `targets` are keys with their URLs; `robot` are the robot's tables in the configuration, in
    which any text of the form HOST:PORT is taken for a connection to the robot.
    """
    own = {(_host(name), own_port) for name in (_HERE, *own_names)}
    lines = {(_host(host), int(port)) for host, port in _endpoints(robot)}
    for key, url in targets:
        parts = urlsplit(url)
        target = (_host(parts.hostname or ""), parts.port or _PORTS[parts.scheme])
        if target in own:
            raise ValueError(
                f"{key}: {parts.netloc} is this server itself; name the program that is to be told"
            )
        if target in lines:
            raise ValueError(
                f"{key}: {parts.netloc} is the robot's own line; name the program that"
                " is to be told"
            )


def _host(name: str) -> str:
    """Return one spelling for each host, without a name lookup."""
    name = name.strip("[]").rstrip(".")
    try:
        name = host_spelling.of_host(name)
        address = ipaddress.ip_address(name)
    except ValueError:
        return name
    return _HERE if address.is_loopback or address.is_unspecified else str(address)


def _endpoints(tree: Any) -> Iterator[tuple[str, str]]:
    if isinstance(tree, dict | list):
        for one in tree.values() if isinstance(tree, dict) else tree:
            yield from _endpoints(one)
    elif isinstance(tree, str):
        yield from _ENDPOINT.findall(tree)
