"""Files that the configuration names: anything but a sensible file is a sentence."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from tests.turned_clock import TurnedClock

from wax.capture.find_sources import make_sources
from wax.clock import SystemClock
from wax.commands.doctor.files import files
from wax.commands.doctor.verdict import Check, examine
from wax.commands.replay.library import Library
from wax.config import settings as config
from wax.config.door import DoorSettings
from wax.config.settings import Settings
from wax.door.tunnel import with_key
from wax.errors import WaxError
from wax.hooks.signature import read_secret
from wax.house.house import House
from wax.records import reading
from wax.robot.find_driver import make_driver
from wax.rtc.ice_servers import IceServers
from wax.web import preview_picture
from wax.web.certificate import Certificate

if TYPE_CHECKING:
    from collections.abc import Callable


def settings(name: str, **tables: object) -> Settings:
    """Return a configuration with this file in place of `{}`."""

    def filled(tree: object) -> object:
        if isinstance(tree, dict):
            return {key: filled(one) for key, one in tree.items()}
        if isinstance(tree, list):
            return [filled(one) for one in tree]
        return name if tree == "{}" else tree

    return Settings.model_validate(filled(tables))


RELAY = {"urls": ["turn:example.org"], "secret_file": "{}"}
ROOM = {"livekit": "wss://example.org", "api_key": "key", "api_secret_file": "{}"}
MAVLINK = {"driver": "mavlink", "mavlink": {"signing_key": "{}"}}


def _house(name: str, **keys: str) -> None:
    House(settings(name, mqtt=keys), TurnedClock(), seen=dict, act=lambda _: None)


def _relay(name: str) -> None:
    one = settings(name, relay=RELAY)
    IceServers(one.network, one.relay)


def _film(name: str) -> None:
    one = settings(name, video={"source": "{}"}, audio={"source": "none"})
    clock = SystemClock()
    make_sources(one.video, one.audio, clock, make_driver(one.robot, clock))


READERS: dict[str, Callable[[str], object]] = {
    "configuration": lambda name: config.load(Path(name)),
    "certificate": lambda name: Certificate(Path(name), Path(name)).context(),
    "fingerprint": lambda name: Certificate(Path(name), Path(name)).fingerprint(),
    "relay": _relay,
    "room": lambda name: settings(name, publish=[ROOM]).publish[0].secret(),
    "hook": lambda name: read_secret(name, "hook[0].secret_file"),
    "password": lambda name: _house(name, url="mqtt://home", user="rover", password_file="{}"),
    "authority": lambda name: _house(name, url="mqtts://home", ca_file="{}"),
    "picture": preview_picture.read,
    "film": _film,
    "signing key": lambda name: make_driver(settings(name, robot=MAVLINK).robot, SystemClock()),
    "tape": lambda name: Library(Path(name)),
    "records": lambda name: reading.read(Path(name), "visits", None),
}
"""Each reader as the server or a command calls it at its start."""


def no_file(kind: str, folder: Path) -> str:
    """Return the path of something that cannot be read, or never ends."""
    path = folder / "named.mcap"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
        (path / "something").touch()
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "circle":
        path.symlink_to(path)
    elif kind == "1 GB":
        with path.open("wb") as file:
            file.truncate(1_000_000_000)
    return "named\0.mcap" if kind == "null character" else str(path)


KINDS = ("pipe", "folder", "device", "circle", "1 GB", "null character")


@pytest.mark.timeout(10)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("reader", READERS)
def test_what_is_no_file_is_a_sentence(reader: str, kind: str, tmp_path: Path) -> None:
    """The sentence names the file, and nothing hangs, fills the memory or prints a traceback."""
    name = no_file(kind, tmp_path)
    with pytest.raises(WaxError) as refused:
        READERS[reader](name)
    said = str(refused.value)
    assert "named" in said
    assert len(said.splitlines()) == 1


@pytest.mark.parametrize("reader", ["relay", "room", "hook", "password", "signing key"])
def test_a_secret_that_is_kept_from_a_service_is_a_sentence(
    reader: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sentence has the line by which systemd gives the service a copy."""

    def refuse(*_: object) -> int:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    name = tmp_path / "secret"
    name.touch(0o600)
    monkeypatch.setattr(os, "open", refuse)  # root reads whatever there is
    with pytest.raises(WaxError, match=f"Permission denied.*: LoadCredential=secret:{name}"):
        READERS[reader](str(name))


@pytest.mark.timeout(10)
@pytest.mark.parametrize("kind", KINDS)
def test_ssh_is_not_given_a_key_that_it_would_wait_for(kind: str, tmp_path: Path) -> None:
    """The tunnel and the doctor report a key file on which ssh would hang, and do not start ssh."""
    with pytest.raises(OSError, match=r"."):
        with_key(DoorSettings.model_construct(key_file=no_file(kind, tmp_path)))


@pytest.mark.timeout(10)
@pytest.mark.parametrize(
    "tables",
    [
        {"relay": RELAY},
        {"publish": [ROOM]},
        {"robot": MAVLINK},
        {"page": {"picture": "{}"}},
        {"voice": {"speaker": "{}/gone/voice.wav"}},
    ],
    ids=lambda tables: next(iter(tables)),
)
def test_the_doctor_reads_what_no_other_check_does(
    tables: dict[str, object], tmp_path: Path
) -> None:
    """A pipe in place of a file is a verdict of `wax doctor` that names it."""
    name = no_file("pipe", tmp_path)
    assert examine(Check("files", lambda: files(Settings()))).level == "ok"
    verdict = examine(Check("files", lambda: files(settings(name, **tables))))
    assert verdict.level == "bad"
    assert "named.mcap" in verdict.sentence or "gone" in verdict.sentence
