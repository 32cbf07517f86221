"""What a viewer is told of STUN and TURN: credentials that end, and never the secret."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
from typing import TYPE_CHECKING

import pytest

from wax.config.settings import NetworkSettings, RelaySettings, Settings
from wax.errors import StartError
from wax.rtc.ice_servers import IceServers

if TYPE_CHECKING:
    from pathlib import Path

SECRET = "no viewer sees this"
URLS = ["turn:example.org:3478", "turns:example.org?transport=tcp"]


def test_there_are_none_unless_configured() -> None:
    """So that no outside host is contacted."""
    assert IceServers(NetworkSettings(), RelaySettings()).of("ada", 1000.0) == []


def test_credentials_are_those_that_coturn_computes() -> None:
    """The name says when they end, ten minutes from now at most, and the secret stays here."""
    relay = RelaySettings(urls=URLS, secret=SECRET)
    (told,) = IceServers(NetworkSettings(), relay).of("ada", 1_000_000.9)
    assert told["urls"] == URLS
    assert told["username"] == "1000600:ada"
    signed = hmac.new(SECRET.encode(), b"1000600:ada", hashlib.sha1).digest()
    assert base64.b64decode(told["credential"]) == signed
    assert SECRET not in json.dumps(told)


def test_the_secret_is_in_no_log() -> None:
    """A traceback shows settings, but not that one."""
    relay = RelaySettings(urls=URLS, secret=SECRET)
    assert SECRET not in repr(relay)
    assert SECRET not in str(Settings(relay=relay))


def test_each_viewer_gets_their_own() -> None:
    """And at another time others again."""
    servers = IceServers(NetworkSettings(), RelaySettings(urls=URLS, secret=SECRET))
    told = [servers.of(name, at_s)[0] for name, at_s in (("a", 0.0), ("b", 0.0), ("a", 1.0))]
    assert len({one["credential"] for one in told}) == 3


def test_the_secret_may_be_in_a_file(tmp_path: Path) -> None:
    """With or without a line's end."""
    file = tmp_path / "secret"
    file.write_text(f"{SECRET}\n")
    network = NetworkSettings(stun=["stun:example.org"])
    of_file = IceServers(network, RelaySettings(urls=URLS, secret_file=str(file)))
    of_text = IceServers(network, RelaySettings(urls=URLS, secret=SECRET))
    assert of_file.of("ada", 0.0) == of_text.of("ada", 0.0)
    assert of_file.of("ada", 0.0)[0] == {"urls": "stun:example.org"}


@pytest.mark.parametrize(("text", "says"), [(None, "cannot be read"), (" \n", "is empty")])
def test_a_secret_that_is_not_there_is_a_sentence(
    text: str | None, says: str, tmp_path: Path
) -> None:
    """The server does not start with credentials that the relay would refuse."""
    file = tmp_path / "secret"
    if text is not None:
        file.write_text(text)
    with pytest.raises(StartError, match=rf"relay.secret_file: {file} {says}"):
        IceServers(NetworkSettings(), RelaySettings(urls=URLS, secret_file=str(file)))
