"""Reads the key for signed messages, from a file that nobody else may read."""

from __future__ import annotations

import stat
from typing import Final

from wax.errors import ConfigError, reason_of
from wax.named_file import check, is_credential, read_secret, secret_file

KEY_BYTES: Final = 32
_KEY: Final = "robot.mavlink.signing_key"


def read_key(name: str) -> bytes:
    """Return the key in the file; raises `ConfigError`."""
    path = secret_file(name)
    try:
        data = read_secret(name)
        mode = check(path).st_mode
    except OSError as error:
        raise ConfigError(f"{_KEY}: {path} cannot be read: {reason_of(error)}") from error
    if not is_credential(path) and mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise ConfigError(f"{_KEY}: others may read {path}; type: chmod 600 {path}")
    if len(data) == KEY_BYTES:
        return data
    try:
        key = bytes.fromhex(data.decode("ascii").strip())
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise ConfigError(
            f"{_KEY}: {path} has no key; write {KEY_BYTES} bytes or {2 * KEY_BYTES} hexadecimal"
            f" digits into it, for example by: openssl rand -hex {KEY_BYTES} > {path}"
        )
    return key
