"""`wax init --door`: one line makes a robot reachable from anywhere."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import load_ssh_private_key
from tests.door.door_lines import SEED, door_line

from wax.__main__ import main
from wax.commands.init.command import init
from wax.commands.init.found import Found
from wax.config import settings as config
from wax.errors import ConfigError
from wax.rtc.ice_servers import IceServers

if TYPE_CHECKING:
    from wax.config.settings import Settings

MINE = """# My robot.
[video]
source = "testcard"   # for now
[server]
host = "0.0.0.0"
https = true
[network]   # at home
udp_port = 9000
"""


def is_through_door(settings: Settings, folder: Path) -> None:
    """Check that the settings use the door, and that each secret is private."""
    assert settings.server.public_url == "https://robot.example.org"
    assert settings.server.trusted_proxies == ["127.0.0.1", "::1"]
    assert not settings.server.https
    assert settings.network.mode == "full-ice"
    assert settings.network.stun == ["stun:robot.example.org:3478"]
    assert (settings.door.host, settings.door.port) == ("robot.example.org", 20001)
    assert IceServers(settings.network, settings.relay).for_viewer("1", 0.0)[1]["credential"]
    for name in (settings.door.key_file, settings.relay.secret_file):
        assert (folder / name).stat().st_mode & 0o777 == 0o600
    key = load_ssh_private_key(Path(settings.door.key_file).read_bytes(), password=None)
    assert isinstance(key, Ed25519PrivateKey)
    assert key.private_bytes_raw() == SEED


def test_a_new_robot_with_a_door(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One command configures a new robot with a door, and prints none of its line."""
    path = tmp_path / "robot.toml"
    assert main(["init", "--yes", "--door", door_line(), str(path)]) == 0
    is_through_door(config.load(path), tmp_path)
    assert "c0ffee" not in capsys.readouterr().out + path.read_text(encoding="utf-8")


def test_a_robot_that_is_there_gets_one(tmp_path: Path) -> None:
    """An existing file keeps its other keys and comments; a new line replaces the first."""
    path = tmp_path / "robot.toml"
    path.write_text(MINE, encoding="utf-8")
    for name in ("old.example.org", "robot.example.org"):
        init(path, ask=None, tell=lambda _: None, door=door_line(name=name))
    settings = config.load(path)
    is_through_door(settings, tmp_path)
    text = path.read_text(encoding="utf-8")
    assert '# My robot.\n[video]\nsource = "testcard"   # for now\n' in text
    assert (settings.server.host, settings.network.udp_port) == ("0.0.0.0", 9000)
    assert "old.example.org" not in text
    assert "old.example.org" in (tmp_path / "robot.toml~").read_text(encoding="utf-8")


def test_a_line_can_be_pasted_at_a_question(tmp_path: Path) -> None:
    """The question for a line is repeated until it is valid."""
    replies = iter(["", "", "", "", "3", door_line()[:99], door_line()])
    told: list[str] = []
    path = tmp_path / "robot.toml"
    init(path, ask=lambda _: next(replies), tell=told.append, detect=Found)
    is_through_door(config.load(path), tmp_path)
    assert any("cut or mistyped" in one for one in told)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[server", "not valid TOML"),
        ('server = { host = "localhost" }', "add by hand:\n.server.\npublic_url = "),
        ('[relay]\nurls = [\n"turn:a:1",\n]\nsecret = "x"', "add by hand"),
        ('[server]\ncertificate = "a"\nkey = "b"', "leave https and certificate out"),
    ],
)
def test_a_file_that_is_not_understood_stays(tmp_path: Path, text: str, why: str) -> None:
    """A file that cannot be edited stays unchanged, and what to write is printed."""
    path = tmp_path / "robot.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=why):
        init(path, ask=None, tell=print, door=door_line())
    assert path.read_text(encoding="utf-8") == text
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("line", ["", door_line()[:-1]])
def test_a_wrong_line_is_said_before_anything_is_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], line: str
) -> None:
    """A wrong line is one sentence and wrong use, even without a terminal."""
    path = tmp_path / "robot.toml"
    assert main(["init", "--door", line, str(path)]) == 2
    said = capsys.readouterr().err
    assert (said.count("\n"), "door" in said) == (1, True)
    assert not path.exists()
