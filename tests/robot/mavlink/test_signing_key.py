"""The key for signed messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.errors import ConfigError
from wax.robot.find_driver import make_driver
from wax.robot.mavlink.signing_key import read_key

if TYPE_CHECKING:
    from pathlib import Path

KEY = bytes(range(32))


def write(path: Path, data: bytes, mode: int = 0o600) -> str:
    path.write_bytes(data)
    path.chmod(mode)
    return str(path)


@pytest.mark.parametrize("data", [KEY, KEY.hex().encode(), KEY.hex().upper().encode() + b"\n"])
def test_a_key_is_bytes_or_digits(tmp_path: Path, data: bytes) -> None:
    """32 raw bytes, or 64 hexadecimal digits, if need be with a newline."""
    assert read_key(write(tmp_path / "key", data)) == KEY


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660, 0o644])
def test_a_key_that_others_may_read_is_refused(tmp_path: Path, mode: int) -> None:
    """The error is the command that fixes it."""
    name = write(tmp_path / "key", KEY, mode)
    with pytest.raises(ConfigError, match=f"chmod 600 {name}"):
        read_key(name)


def test_the_copy_that_systemd_gives_a_service_is_accepted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its ACL looks like a group permission, but gives the group none."""
    write(tmp_path / "key", KEY, 0o440)
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(tmp_path))
    assert read_key("/etc/wax/key") == read_key(str(tmp_path / "key")) == KEY


@pytest.mark.parametrize("data", [b"", b"secret", KEY[:31], KEY.hex().encode()[:-1], b"z" * 64])
def test_an_invalid_key_is_refused(tmp_path: Path, data: bytes) -> None:
    """The error says what a key is and how to make one."""
    with pytest.raises(ConfigError, match="openssl rand -hex 32"):
        read_key(write(tmp_path / "key", data))


def test_a_missing_key_stops_the_start(tmp_path: Path) -> None:
    """The error names the key: the robot is not driven unsigned instead."""
    settings = RobotSettings.model_validate(
        {"driver": "mavlink", "mavlink": {"signing_key": str(tmp_path / "none")}}
    )
    with pytest.raises(ConfigError, match=r"^robot\.mavlink\.signing_key: .* cannot be read"):
        make_driver(settings, SystemClock())
