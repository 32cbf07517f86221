"""Parses the line that a door prints: all that a robot must know of it, in one word. Pure.

``wax-door-1:DOOR:NAME:PORT:HOST-KEY:SEED:SECRET:SUM``: the names of door and robot, the door's
Ed25519 key and the seed of the robot's own (32 bytes each, RFC 4648 base64), the robot's secret for
the relay, and the first eight hexadecimal digits of the SHA-256 of all before the last colon.
Anyone who has the line can serve a page of their own under the robot's name, and use the door's
relay; `door.sh --forget NAME` revokes both.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import re
from dataclasses import dataclass, field
from typing import Final

from wax.errors import ConfigError

_BEGINS: Final = "wax-door-"
_VERSION: Final = f"{_BEGINS}1"
_SUM: Final = 8
_TYPE: Final = b"\0\0\0\x0bssh-ed25519\0\0\0\x20"
"""The prefix of an Ed25519 key of 32 bytes (RFC 8709, 4)."""
_NAME: Final = r"[a-z0-9](?:[a-z0-9.-]{0,251}[a-z0-9])?"
_FIELDS: Final = re.compile(
    rf"(?P<door>{_NAME}):(?P<name>{_NAME}):(?P<port>[0-9]{{1,5}})"
    r":(?P<host>[A-Za-z0-9+/]{43}=):(?P<seed>[A-Za-z0-9+/]{43}=):(?P<secret>[0-9a-f]{32,64})"
)
_AGAIN: Final = "copy it once more, whole, from where the door printed it"


@dataclass(frozen=True, slots=True)
class DoorLine:
    """`host` is the door, `name` the robot's page there; `host_key` is in OpenSSH's format.

    `seed` is the seed of the robot's private key (RFC 8032).
    """

    host: str
    name: str
    port: int
    host_key: str
    seed: bytes = field(repr=False)
    relay_secret: str = field(repr=False)


def read(text: str) -> DoorLine:
    """Return the parsed line; raises `ConfigError` with one sentence that never quotes the line."""
    line = "".join(text.split())  # a terminal or an e-mail may have wrapped it
    if not line.startswith(_BEGINS):
        raise ConfigError(f"This is no line of a door, which begins with {_VERSION}; {_AGAIN}.")
    head, _, rest = line.partition(":")
    if head != _VERSION:
        raise ConfigError(
            f"The line is of another version ({head[:20]}) than {_VERSION}; set up the door with"
            " the door.sh of this version of WAX, or update WAX."
        )
    body, _, digits = rest.rpartition(":")
    digest = hashlib.sha256(f"{head}:{body}".encode(errors="replace")).hexdigest()
    if digits != digest[:_SUM]:
        raise ConfigError(f"The door's line is cut or mistyped; {_AGAIN}.")
    found = _FIELDS.fullmatch(body)
    if found is None or not 0 < int(found["port"]) < 65_536:
        raise ConfigError(f"The door's line is whole, but not understood; {_AGAIN}.")
    try:
        host, seed = (base64.b64decode(found[key], validate=True) for key in ("host", "seed"))
    except binascii.Error:
        raise ConfigError(f"The door's line is whole, but not understood; {_AGAIN}.") from None
    host_key = f"ssh-ed25519 {base64.b64encode(_TYPE + host).decode()}"
    return DoorLine(
        found["door"], found["name"], int(found["port"]), host_key, seed, found["secret"]
    )
