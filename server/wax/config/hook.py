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
    ),
    allowed.said('an address as "https://example.org/hook", without a user\'s name'),
    ONE_URL,
    AfterValidator(_whole),
]


EventName = Annotated[
    str,
    Field(pattern=f"^({'|'.join(map(re.escape, NAMES))})$"),
    allowed.said(allowed.words({"enum": list(NAMES)})),
]


class HookSettings(ConfigTable):
    """Programs of yours that are told what happens here, each event by a POST of one JSON object.
    All have version (1), timestamp and type; these are the types, with what else they have (`wax
    hook schema` prints it as JSON Schema):
      server.ready, server.ending    software, its version
      door.opened, door.closed       by [access] hours or by you; one of the two follows each start
      queue.waiting, queue.empty     somebody waits for a turn, or nobody does any more
      turn.began                     turn, viewer (numbers), name
      turn.ended                     the same, and why: "expired", "left", "gone", "idle",
                                     "ended" (by you), "not_allowed" or "server_ending"
      stop.pressed, stop.released    stop (its number), role ("observer", "operator", "host" or
                                     "house"), name; a Stop in force is told again when the server
                                     is restarted
      stop.automatic                 viewer, name, why: the robot was stopped while somebody drove;
                                     one a second at most
      fault.began, fault.mended      part ("camera", "microphone", "robot", "battery" or "gauge"),
                                     which (its name, where there are several), why; after 3 s of
                                     it, or 10 s without
      cluster.lost, cluster.back     room, the number of its table [[publish]]
      tunnel.lost, tunnel.back       why: whether people elsewhere reach the page through [door]
      viewer.removed, viewer.banned  viewer, name
      tape.kept                      by: "host", "operator" or "fault"
    Each is signed as Standard Webhooks 1.0 has it (webhook-id, webhook-timestamp,
    webhook-signature), so its libraries check it. A receiver has 10 s to answer with 2xx; redirects
    are not followed. An event that is not accepted is sent again, with the same id, for ten
    minutes; `Retry-After` (with 429 and 503) is waited for, up to 300 s. Any 4xx but 408, 425 and
    429 refuses the event for good, 410 switches the hook off until the next start. Events of stop
    and fault come in order, and so do the others; stop and fault wait for no others: sort by
    `timestamp`. If more than 200 wait, the oldest are lost. Driving never waits for a hook. `wax
    hook test` sends a sample, of the type hook.test.
    """

    url: HookUrl
    """Where events are posted; its path is shown nowhere."""
    events: Annotated[list[EventName], Field(max_length=len(NAMES))] = []
    """The events that are sent; all of them if the list is empty."""
    secret_file: Annotated[str, Field(min_length=1)]
    """The file with the secret that signs events; make one: (umask 077; echo whsec_$(openssl rand
    -base64 32) > FILE)."""
    ca_file: str = ""
    """The file with your own CA certificate, if that CA signed the receiver's; as in [mqtt]."""
    names: bool = False
    """Whether people's names are told; otherwise name is null. Addresses never are."""

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
