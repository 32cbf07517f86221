"""A viewer gets STUN and TURN servers with credentials that expire, and never the secret."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
from typing import TYPE_CHECKING

import pytest

from wax.clock import SystemClock
from wax.config.network import NetworkSettings
from wax.config.relay import RelaySettings
from wax.config.settings import Settings
from wax.edge.turnstile import Turnstile
from wax.errors import StartError
from wax.rtc.ice_servers import IceServers
from wax.rtc.network import Network

if TYPE_CHECKING:
    from pathlib import Path

SECRET = "no viewer sees this"
URLS = ["turn:example.org:3478", "turns:example.org?transport=tcp"]


def test_there_are_none_unless_configured() -> None:
    """Without configuration there are no servers, so no outside host is contacted."""
    assert IceServers(NetworkSettings(), RelaySettings()).for_viewer("ada", 1000.0) == []


def test_credentials_are_those_that_coturn_computes() -> None:
    """The user name contains the expiry, ten minutes ahead at most; the secret stays here."""
    relay = RelaySettings(urls=URLS, secret=SECRET)
    (told,) = IceServers(NetworkSettings(), relay).for_viewer("ada", 1_000_000.9)
    assert told["urls"] == URLS
    assert told["username"] == "1000600:ada"
    signed = hmac.new(SECRET.encode(), b"1000600:ada", hashlib.sha1).digest()
    assert base64.b64decode(told["credential"]) == signed
    assert SECRET not in json.dumps(told)


def test_the_secret_is_in_no_log() -> None:
    """A traceback shows settings, but not the secret."""
    relay = RelaySettings(urls=URLS, secret=SECRET)
    assert SECRET not in repr(relay)
    assert SECRET not in str(Settings(relay=relay))


def test_each_viewer_gets_their_own_credentials() -> None:
    """Credentials differ by viewer and by time."""
    servers = IceServers(NetworkSettings(), RelaySettings(urls=URLS, secret=SECRET))
    told = [
        servers.for_viewer(name, at_s)[0] for name, at_s in (("a", 0.0), ("b", 0.0), ("a", 1.0))
    ]
    assert len({one["credential"] for one in told}) == 3


def test_each_of_our_own_relays_has_a_name_of_its_own() -> None:
    """Our own relays have distinct names, because TURN servers limit relays per name."""
    settings = NetworkSettings(mode="full-ice")
    servers = IceServers(settings, RelaySettings(urls=URLS, secret=SECRET))
    clock = SystemClock()
    network = Network(settings, servers, clock, Turnstile(clock))
    names = {(network.configuration().iceServers or [])[0].username for _ in range(20)}
    assert len(names) == 20
    assert all("server-" in str(name) for name in names)


def test_a_service_reads_what_systemd_gives_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A secret that its user cannot read is read under its file name from systemd's credentials."""
    copies = tmp_path / "credentials"
    copies.mkdir()
    (copies / "wax.turn-secret").write_text(SECRET)
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(copies))
    relay = RelaySettings(urls=URLS, secret_file="/etc/wax/no such folder/wax.turn-secret")
    (told,) = IceServers(NetworkSettings(), relay).for_viewer("ada", 1000.0)
    (other,) = IceServers(NetworkSettings(), RelaySettings(urls=URLS, secret=SECRET)).for_viewer(
        "ada", 1e3
    )
    assert told == other


def test_the_secret_may_be_in_a_file(tmp_path: Path) -> None:
    """The secret is read from a file, with or without a trailing newline."""
    file = tmp_path / "secret"
    file.write_text(f"{SECRET}\n")
    network = NetworkSettings(stun=["stun:example.org"])
    of_file = IceServers(network, RelaySettings(urls=URLS, secret_file=str(file)))
    of_text = IceServers(network, RelaySettings(urls=URLS, secret=SECRET))
    assert of_file.for_viewer("ada", 0.0) == of_text.for_viewer("ada", 0.0)
    assert of_file.for_viewer("ada", 0.0)[0] == {"urls": "stun:example.org"}


@pytest.mark.parametrize(("text", "says"), [(None, "cannot be read"), (" \n", "is empty")])
def test_a_missing_secret_is_a_sentence(text: str | None, says: str, tmp_path: Path) -> None:
    """The server does not start with credentials that the relay would refuse."""
    file = tmp_path / "secret"
    if text is not None:
        file.write_text(text)
    with pytest.raises(StartError, match=rf"relay.secret_file: {file} {says}"):
        IceServers(NetworkSettings(), RelaySettings(urls=URLS, secret_file=str(file)))
