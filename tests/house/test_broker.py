"""The link, against Debian's broker: whatever the broker does, the server only reports it."""

from __future__ import annotations

import os
import re
import resource
import signal
import socket
import ssl
import subprocess
import threading
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from paho.mqtt.client import DisconnectFlags
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.reasoncodes import ReasonCode
from structlog.testing import capture_logs
from tests.house.mosquitto import AtHome, Mosquitto, running
from tests.turned_clock import TurnedClock
from tests.until import until

from wax.authority import client_tls
from wax.clock import SystemClock
from wax.commands.doctor import command
from wax.commands.doctor.verdict import Check, examine
from wax.config.mqtt import MqttSettings
from wax.config.settings import Settings
from wax.house import broker, connection, probes
from wax.house.broker import KEPT_S, MOST_EVENTS, BrokerLink
from wax.house.connection import BrokerConnection, BrokerError
from wax.sentence import Sentence
from wax.web.certificate import self_signed

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.system


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reconnect almost at once, so that the tests need not wait."""
    monkeypatch.setattr(broker, "_FIRST_WAIT_S", 0.05)


class Kept(BrokerLink):
    """A link that exposes its connection and what it delivered."""

    connection: BrokerConnection
    taken: list[tuple[str, bytes, bool]]

    def _reach(self) -> BrokerConnection:
        self.connection = super()._reach()
        return self.connection

    def break_off(self) -> None:
        """Break the connection as a network would."""
        self.connection.client.socket().shutdown(socket.SHUT_RDWR)  # type: ignore[union-attr]


def _link(port: int, scheme: str = "mqtt", host: str = "localhost", **keys: Any) -> Kept:
    settings = MqttSettings(url=f"{scheme}://{host}:{port}", **keys)
    taken: list[tuple[str, bytes, bool]] = []

    def take(topic: str, payload: bytes, is_retained: bool) -> None:
        taken.append((topic, payload, is_retained))

    link = Kept(
        settings,
        SystemClock(),
        topic="rover",
        asks={"rover/stop/set": "rover/stop/status"},
        birth="homeassistant/status",
        deliver=take,
    )
    link.taken = taken
    link.states = {"rover/queue": "0"}
    return link


@contextmanager
def _linked(port: int, *args: str, **keys: Any) -> Iterator[Kept]:
    link = _link(port, *args, **keys)
    link.start()
    try:
        yield link
    finally:
        link.close(5)
        link._thread.join(5)
        assert not link._thread.is_alive()


def test_states_are_retained_and_events_are_not(tmp_path: Path) -> None:
    """A later client reads the states but no events; closing publishes "offline"."""
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        with _linked(mosquitto.port) as link:
            link.put('{"type":"tape.kept"}')
            until(lambda: home.events)
            link.states = {"rover/queue": "1"}
            until(lambda: home.value("rover/queue") == "1")
            with AtHome(mosquitto.port) as later:
                until(lambda: "rover/queue" in later.heard)
                assert later.heard["rover/queue"] == ("1", True)
                assert later.heard["rover/status"] == ("online", True)
                assert later.events == []
        until(lambda: home.value("rover/status") == "offline")


def test_only_live_and_bounded_messages_come_in(tmp_path: Path) -> None:
    """No retained copy and no message beyond the limit arrives, even after a reconnection."""
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        home.says("rover/stop/set", "RETAINED", retain=True)
        with _linked(mosquitto.port) as link:
            for number in range(2):
                until(lambda: link.is_connected)
                until(lambda: home.value("rover/status") == "online")
                home.says("rover/stop/set", b"x" * 100_000)
                home.says("rover/other/set", "x")
                until(lambda: _heard(home, link))
                assert {payload for _, payload, _ in link.taken} == {b"NOW"}
                link.taken.clear()
                if number == 0:
                    home.heard.clear()
                    link.break_off()


def _heard(home: AtHome, link: Kept) -> bool:
    """Send a Stop and return whether the link has delivered one."""
    home.says("rover/stop/set", "NOW")
    return bool(link.taken)


def test_a_flood_is_left_before_driving_waits_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A flood ends the connection after the first messages; the host reads why; it reconnects."""
    monkeypatch.setattr(connection, "MOST_PER_S", 50)
    said: list[str | None] = []
    clock = TurnedClock()  # it stands still, so all arrive within one second

    def wait(_: float) -> None:
        said.append(_code(link))
        clock.time_s += 1.0

    with (
        running(tmp_path) as mosquitto,
        AtHome(mosquitto.port) as home,
        _linked(mosquitto.port) as link,
    ):
        monkeypatch.setattr(link._ended, "wait", wait)
        until(lambda: link.is_connected)
        link._clock = link.connection._clock = clock
        for number in range(100):
            home.says("rover/stop/set", str(number), qos=0)
        until(lambda: said and link.is_connected)
        assert said[0] == "house.flooded"
        assert [payload for _, payload, _ in link.taken][:50] == [b"%d" % n for n in range(50)]
        home.says("rover/stop/set", "again")
        until(lambda: link.taken[-1][1] == b"again")


def test_nothing_is_read_of_what_is_too_large() -> None:
    """A packet beyond the announced limit ends the connection; paho would buffer 256 MB of it."""
    accepted, taken = b"\x20\x03\x00\x00\x00", b"\x90\x04\x00\x01\x00\x01"
    publishes = b"\x30\xff\xff\xff\x7f"
    with (
        socket.create_server(("localhost", 0)) as other,
        _answering(other, accepted, taken + publishes) as heard,
    ):
        with pytest.raises(BrokerError, match="The connection has ended: a network protocol error"):
            _link(other.getsockname()[1]).check()
        assert b"\x21\x00\x14" in heard[0]  # Receive Maximum (MQTT 5, 3.1.2.11.3)
        assert b"\x27\x00\x00\x08\x00" in heard[0]  # Maximum Packet Size


def _code(link: BrokerLink) -> str | None:
    return None if link.problem is None else link.problem.code


def test_a_lost_server_is_told_by_the_broker(tmp_path: Path) -> None:
    """The broker sends the will; the link reconnects and publishes all states again."""
    with (
        running(tmp_path) as mosquitto,
        AtHome(mosquitto.port) as home,
        _linked(mosquitto.port) as link,
    ):
        until(lambda: home.value("rover/queue") == "0")
        home.heard.clear()
        link.break_off()
        until(lambda: ("rover/status", "offline") in home.said)
        until(lambda: home.value("rover/queue") == "0")
        assert home.value("rover/status") == "online"


def test_a_killed_broker_is_awaited(tmp_path: Path) -> None:
    """Without a broker, excess events are counted as lost; a new one receives all states."""
    mosquitto = Mosquitto(tmp_path)
    with _linked(mosquitto.port) as link:
        until(lambda: link.problem)
        assert link.problem is not None
        assert link.problem.code == "unreachable.nobody"
        for number in range(MOST_EVENTS + 5):
            link.put(f'"{number}"')
        assert link.lost == 5
        mosquitto.start()
        try:
            until(lambda: link.is_connected)
            assert link.problem is None
            mosquitto.kill()
            until(lambda: link.problem)
            mosquitto.start()
            with AtHome(mosquitto.port) as home:
                until(lambda: home.value("rover/queue") == "0")
        finally:
            mosquitto.kill()


def test_old_events_are_not_told(tmp_path: Path) -> None:
    """An event that has expired is not published: what it reports may have changed."""
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        link = _link(mosquitto.port)
        link._clock = clock = TurnedClock()
        link.put('"old"')
        clock.time_s += KEPT_S + 0.1
        link.put('"new"')
        link.start()
        until(lambda: home.events)
        link.close(5)
        assert (home.events, link.expired) == (['"new"'], 1)


def test_it_is_tried_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    """The link retries for ever, after at most 30 s; a connection resets the backoff."""
    monkeypatch.setattr(broker, "_FIRST_WAIT_S", 1.0)
    link, waited_s = _link(1), list[float]()

    def reach() -> BrokerConnection:
        link.is_connected = len(waited_s) == 7
        raise BrokerError(Sentence("unreachable.silent", {"limit": 1}))

    def wait(wait_s: float) -> None:
        waited_s.append(wait_s)
        if len(waited_s) == 9:
            link._ended.set()

    monkeypatch.setattr(link, "_reach", reach)
    monkeypatch.setattr(link._ended, "wait", wait)
    link._run()
    assert waited_s == [1, 2, 4, 8, 16, 30, 30, 1, 2]


def test_a_broker_that_hangs_holds_up_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hung broker is disconnected, reported and retried, and served once it goes on."""
    monkeypatch.setattr(connection, "KEEPALIVE_S", 1)
    monkeypatch.setattr(broker, "LIMIT_S", 1.0)
    with running(tmp_path) as mosquitto, _linked(mosquitto.port) as link:
        until(lambda: link.is_connected)
        mosquitto.signal(signal.SIGSTOP)
        link.states = {f"rover/{number}": "x" * 10_000 for number in range(1000)}
        link.put("{}")
        until(lambda: link.problem)
        until(lambda: _code(link) == "unreachable.hangs")
        link.states = {"rover/queue": "2"}
        mosquitto.signal(signal.SIGCONT)
        until(lambda: link.is_connected)
        with AtHome(mosquitto.port) as home:
            until(lambda: home.value("rover/queue") == "2")


# paho leaves the socket of a failed handshake to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_wrong_certificate_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A broker with an untrusted authority or another name is refused; `ca_file` adds trust."""
    own = self_signed(tmp_path, ["localhost"], datetime.now(UTC))
    lines = [f"certfile {own.chain}", f"keyfile {own.key}"]
    with running(tmp_path, *lines) as mosquitto:
        with _linked(mosquitto.port, "mqtts") as link:
            until(lambda: link.problem)
            assert link.problem is not None
            assert link.problem.code == "unreachable.own_authority"
            assert "[mqtt] ca_file" in str(link.problem)
        with _linked(mosquitto.port, "mqtts", ca_file=str(own.chain)) as link:
            until(lambda: link.is_connected)
        with _linked(mosquitto.port, "mqtts", "127.0.0.2", ca_file=str(own.chain)) as link:
            until(lambda: link.problem)
            assert not link.is_connected
        monkeypatch.setenv("SSL_CERT_FILE", str(own.chain))
        with _linked(mosquitto.port, "mqtts") as link:
            until(lambda: link.is_connected)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_the_wrong_port_and_what_a_broker_wants_are_sentences(tmp_path: Path) -> None:
    """Debian's broker only hangs up; the link's own diagnosis says why."""
    own = self_signed(tmp_path, ["localhost"], datetime.now(UTC))
    lines = [f"certfile {own.chain}", f"keyfile {own.key}"]
    with running(tmp_path, *lines, f"cafile {own.chain}", "require_certificate true") as mosquitto:
        with pytest.raises(BrokerError, match="write mqtts:// in its address"):
            _link(mosquitto.port).check()
        with pytest.raises(BrokerError, match="wants a client's certificate"):
            _link(mosquitto.port, "mqtts", ca_file=str(own.chain)).check()
    with running(tmp_path) as mosquitto, pytest.raises(BrokerError, match="does not speak TLS"):
        _link(mosquitto.port, "mqtts", ca_file=str(own.chain)).check()


def test_a_broker_without_mqtt_5_is_a_sentence() -> None:
    """A broker that speaks only MQTT 3.1.1 (3.1.2.2) is a sentence that asks for MQTT 5."""
    with (
        socket.create_server(("localhost", 0)) as other,
        _answering(other, b"\x20\x02\x00\x01"),
        pytest.raises(BrokerError, match="needs MQTT 5"),
    ):
        _link(other.getsockname()[1]).check()


def test_an_authority_made_by_hand_is_one(tmp_path: Path) -> None:
    """An authority without a key identifier is accepted, which Python 3.13 refuses by default."""
    own = self_signed(tmp_path, ["localhost"], datetime.now(UTC))
    assert not client_tls(str(own.chain), "mqtt.ca_file").verify_flags & ssl.VERIFY_X509_STRICT


def test_who_is_refused_reads_why(tmp_path: Path) -> None:
    """A refusal gives its reason, by a broker or something else, and never the password."""
    (tmp_path / "password").write_text("secret-4711\n")
    (tmp_path / "passwords").write_text("")
    lines = ["allow_anonymous false", f"password_file {tmp_path}/passwords"]
    with running(tmp_path, *lines) as mosquitto:
        keys = {"user": "rover", "password_file": str(tmp_path / "password")}
        with pytest.raises(BrokerError) as refused:
            _link(mosquitto.port, **keys).check()
        assert str(refused.value) == "It refuses this server: Not authorized."
    with (
        socket.create_server(("localhost", 0)) as other,
        _answering(other, b"HTTP/1.1 400 Bad Request\r\n\r\n"),
        pytest.raises(BrokerError, match=r"perhaps it speaks only MQTT 3\.1\.1"),
    ):
        _link(other.getsockname()[1]).check()


def test_a_topic_that_is_kept_from_us_is_said() -> None:
    """A refused command topic is an error: a Stop at home would silently do nothing."""
    accepted, refused = b"\x20\x03\x00\x00\x00", b"\x90\x04\x00\x01\x00\x87"
    with (
        socket.create_server(("localhost", 0)) as other,
        _answering(other, accepted, refused),
        pytest.raises(BrokerError, match=r"It refuses this server: Not authorized\."),
    ):
        _link(other.getsockname()[1]).check()


class Acl:
    """mosquitto's access list: the robot's rights, and all rights for clients at home.

    mosquitto grants every subscription, and drops at delivery what may not be read.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / "acl"
        self._password = folder / "password"
        self._password.write_text("secret")
        users = folder / "users"
        command = ["mosquitto_passwd", "-b", "-c", str(users), "rover", "secret"]
        subprocess.run(command, check=True, capture_output=True)
        self.lines = ["allow_anonymous true", f"password_file {users}", f"acl_file {self._file}"]
        self.keys = {"user": "rover", "password_file": str(self._password)}

    def allow(self, *rights: str, broker: Mosquitto | None = None) -> None:
        lines = ["topic readwrite #", "user rover", *(f"topic {one}" for one in rights)]
        self._file.write_text("\n".join([*lines, ""]))
        if broker is not None:
            broker.signal(signal.SIGHUP)


ALL = ("readwrite rover/#", "readwrite homeassistant/#")


def test_a_stop_that_does_not_arrive_is_not_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stop is offline at home, and its topic is named to the host, until a probe of it arrives."""
    monkeypatch.setattr(probes, "AGAIN_S", 0.2)
    monkeypatch.setattr(probes, "LIMIT_S", 0.2)
    monkeypatch.setattr(probes, "PERIOD_S", 0.2)
    acl = Acl(tmp_path)
    acl.allow("write rover/#")
    with running(tmp_path, *acl.lines) as mosquitto, AtHome(mosquitto.port) as home:
        with _linked(mosquitto.port, **acl.keys) as link:
            until(lambda: home.value("rover/status") == "online")
            assert home.value("rover/stop/status") == "offline"
            until(lambda: link.troubles)
            said = "What is sent to rover/stop/set does not arrive here within .* read there"
            assert re.match(said, str(link.troubles[0]))
            acl.allow(*ALL, broker=mosquitto)
            until(lambda: home.value("rover/stop/status") == "online")
            until(lambda: not link.troubles)
            acl.allow("write rover/#", broker=mosquitto)  # while connected
            until(lambda: home.value("rover/stop/status") == "offline")
        assert ("rover/stop/status", "online") not in home.said[: home.said.index(OFFERED)]
        assert link.taken == []


OFFERED = ("rover/status", "online")


def test_a_stop_that_cannot_be_tried_is_not_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot that may read its commands but not probe them offers none, and the host reads why."""
    monkeypatch.setattr(probes, "LIMIT_S", 0.2)
    acl = Acl(tmp_path)
    acl.allow("write rover/+", "write rover/+/status", "read rover/#")
    with (
        running(tmp_path, *acl.lines) as mosquitto,
        AtHome(mosquitto.port) as home,
        _linked(mosquitto.port, **acl.keys) as link,
    ):
        until(lambda: link.troubles)
        assert link.troubles[0] == Sentence("house.not_proven", {"topics": "rover/stop/set"})
        until(lambda: home.value("rover/stop/status") == "offline")


def test_what_may_not_be_said_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A refused discovery message is reported, and published again until it is accepted."""
    monkeypatch.setattr(connection, "AGAIN_S", 0.2)
    acl, device = Acl(tmp_path), "homeassistant/device/rover/config"
    acl.allow("readwrite rover/#")
    with (
        running(tmp_path, *acl.lines) as mosquitto,
        AtHome(mosquitto.port) as home,
        _linked(mosquitto.port, **acl.keys) as link,
    ):
        link.states = {device: "{}"}
        until(lambda: link.troubles)
        values = {"topics": device, "why": "Not authorized"}
        assert link.troubles == [Sentence("house.not_said", values)]
        acl.allow(*ALL, broker=mosquitto)
        until(lambda: home.value(device) == "{}")
        until(lambda: not link.troubles)


def test_what_is_too_large_for_a_broker_is_left_out(tmp_path: Path) -> None:
    """Only a message beyond the broker's limit is left out, and the host reads of it once.

    A message of exactly the limit is published, and Stop works.
    """
    device = "homeassistant/device/rover/config"
    fits = 1300 - len("rover/long") - 8
    with (
        running(tmp_path, "max_packet_size 1300") as mosquitto,
        AtHome(mosquitto.port) as home,
        capture_logs() as logs,
        _linked(mosquitto.port) as link,
    ):
        link.states = {device: "x" * 1300, "rover/long": "x" * fits, "rover/queue": "1"}
        until(lambda: home.value("rover/queue") == "1")
        assert home.value("rover/long") == "x" * fits
        link.states = {device: "x" * 1300, "rover/long": "x" * (fits + 1), "rover/queue": "2"}
        until(lambda: home.value("rover/queue") == "2")
        assert home.value("rover/stop/status") == "online"
        until(lambda: _heard(home, link))
        topics = f"{device}, rover/long"
        assert link.troubles == [Sentence("house.too_large", {"topics": topics, "most": 1300})]
        assert device not in home.heard
        link.states = {device: "{}", "rover/long": "x"}
        until(lambda: not link.troubles)
        until(lambda: home.value(device) == "{}")
    assert [line["event"] for line in logs].count("connected to the MQTT broker") == 1
    told = [line["why"] for line in logs if "why" in line]
    assert len(told) == len(set(told))


def test_a_stop_too_large_to_try_is_not_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A broker that takes less than such a probe has: the host reads why there is no button."""
    monkeypatch.setattr(probes, "LIMIT_S", 0.2)
    with (
        running(tmp_path, "max_packet_size 1000") as mosquitto,
        AtHome(mosquitto.port) as home,
        _linked(mosquitto.port) as link,
    ):
        told = Sentence("house.not_tried", {"topics": "rover/stop/set", "most": 1000})
        until(lambda: link.troubles == [told])
        until(lambda: home.value("rover/stop/status") == "offline")


def test_an_old_will_has_not_the_last_word(tmp_path: Path) -> None:
    """A late will of an old connection, as after a power cut, is corrected to "online"."""
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        old = _link(mosquitto.port)._reach()
        with _linked(mosquitto.port) as link:
            until(lambda: home.value("rover/status") == "online")
            with pytest.raises(BrokerError):  # taken over, and so without a will
                until(old.step)
            home.says("rover/status", "offline", retain=True)  # as the will of another client
            until(lambda: home.said[-1] == ("rover/status", "online"))
            assert link.troubles == []


def test_a_status_that_does_not_stay_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A retained status that cannot be corrected is reported to the host."""
    monkeypatch.setattr(connection, "AGAIN_S", 0.2)
    acl = Acl(tmp_path)
    acl.allow("readwrite rover/stop/#", "read rover/status")
    with running(tmp_path, *acl.lines) as mosquitto, AtHome(mosquitto.port) as home:
        home.says("rover/status", "offline", retain=True)
        with _linked(mosquitto.port, **acl.keys) as link:
            until(lambda: "house.not_kept" in [one.code for one in link.troubles])


def test_whoever_takes_our_place_is_told_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A takeover is reported after reconnecting, even unannounced; a second one slows the retry."""
    monkeypatch.setattr(broker, "_LONGEST_WAIT_S", 0.1)
    waited_s: list[float] = []
    with running(tmp_path) as mosquitto, _linked(mosquitto.port) as link:
        wait = link._ended.wait

        def wait_as_long(wait_s: float) -> None:
            waited_s.append(wait_s)
            wait(wait_s)

        monkeypatch.setattr(link._ended, "wait", wait_as_long)
        for number in range(1, 3):
            until(lambda: link.is_connected)
            rival = _link(mosquitto.port)._reach()
            until(lambda: len(waited_s) == number)  # noqa: B023 - at once
            until(lambda: link.is_connected and link.troubles)
            assert link.troubles[0].code == "house.taken_over"
            with pytest.raises(BrokerError):
                until(rival.step)
        assert waited_s == [0.05, 0.1]


def test_what_our_own_connections_leave_is_no_rivals(tmp_path: Path) -> None:
    """Neither an earlier process's status nor our own will counts as a rival."""
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        with _linked(mosquitto.port):
            until(lambda: home.value("rover/status") == "online")
        with _linked(mosquitto.port) as link:
            until(lambda: link.is_connected)
            until(lambda: home.value("rover/status") == "online")
            home.heard.clear()
            link.break_off()
            until(lambda: home.value("rover/status") == "online")
            until(lambda: link.connection._listening is None)
            assert link.troubles == []


def test_a_broker_that_says_who_took_our_place_is_believed() -> None:
    """The reason code of a takeover is reported as such."""
    accepted, taken = b"\x20\x03\x00\x00\x00", b"\x90\x04\x00\x01\x00\x01"
    with (
        socket.create_server(("localhost", 0)) as other,
        _answering(other, accepted, taken, b"\xe0\x02\x8e\x00"),
        pytest.raises(BrokerError, match="Another server has this one's place"),
    ):
        _link(other.getsockname()[1]).check()


def test_home_assistants_start_has_all_said_again(tmp_path: Path) -> None:
    """A live birth message has all states published again; a retained one does not."""
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        home.says("homeassistant/status", "online", retain=True)
        with _linked(mosquitto.port):
            until(lambda: ("rover/queue", "0") in home.said)
            home.says("homeassistant/status", "offline")
            home.says("homeassistant/status", "online")
            until(lambda: home.said.count(("rover/queue", "0")) == 2)
            assert home.said.count(("rover/status", "online")) == 2


def test_a_broker_may_want_an_identifier(tmp_path: Path) -> None:
    """A broker that refuses empty client ids is served."""
    with running(tmp_path, "allow_zero_length_clientid false") as mosquitto:
        _link(mosquitto.port).check()


def test_what_a_broker_ends_the_connection_for_is_left_or_told() -> None:
    """A disconnection instead of a refusal is reported, or ends the optional subscriptions."""
    accepted, taken = b"\x20\x03\x00\x00\x00", b"\x90\x04\x00\x01\x00\x01"
    unauthorized = b"\xe0\x02\x87\x00"
    with socket.create_server(("localhost", 0)) as other:
        link = _link(other.getsockname()[1])
        with _answering(other, accepted, taken, unauthorized) as heard:
            opened = link._connection("server")
            with pytest.raises(BrokerError) as ended:
                opened.open("localhost", link._target.port, 5)
        assert b"wax-probe" in heard[2]
        values = {"topics": "rover/stop/set", "why": "Not authorized"}
        assert ended.value.sentence == Sentence("house.not_said", values)
        opened._listening = 5
        opened._on_disconnect(
            opened.client,
            None,
            DisconnectFlags(is_disconnect_packet_from_server=True),
            ReasonCode(PacketTypes.DISCONNECT, identifier=0x87),
            None,
        )
        assert not opened.may_listen


def test_the_end_waits_for_no_broker_that_is_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    """`close` does not wait for a broker that never answered."""

    def wait(_: float) -> None:
        raise AssertionError

    with socket.create_server(("localhost", 0)) as silent:
        link = _link(silent.getsockname()[1])
        link.start()
        line, _ = silent.accept()
        with monkeypatch.context() as patched:
            patched.setattr(link._thread, "join", wait)
            link.close(1)
        line.close()
        link._thread.join(5)
        assert not link._thread.is_alive()


def test_many_open_files_are_no_limit(tmp_path: Path) -> None:
    """The link works with a descriptor above 1,023, which `select` refuses."""
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    with ExitStack() as kept:
        kept.callback(resource.setrlimit, resource.RLIMIT_NOFILE, limits)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, limits[1]), limits[1]))
        others = [kept.enter_context(Path(os.devnull).open()) for _ in range(1024)]
        assert others[-1].fileno() >= 1024
        mosquitto = kept.enter_context(running(tmp_path))
        _link(mosquitto.port).check()


def test_the_doctor_tries_the_broker(tmp_path: Path) -> None:
    """`wax doctor` names the prefix of the topics, and sends home nothing but probes."""
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        settings = Settings.model_validate({"mqtt": {"url": f"mqtt://localhost:{mosquitto.port}"}})
        verdict = examine(Check("MQTT broker", lambda: command._broker(settings)))
        said = f"localhost:{mosquitto.port} accepts this server, and commands arrive; topics"
        assert (verdict.level, verdict.sentence) == (
            "ok",
            f"{said} begin with wax/wax/. It takes what this server publishes.",
        )
        with AtHome(mosquitto.port) as other:
            other.says("end", "x")
        until(lambda: "end" in home.heard)
        assert all(text.startswith("wax-probe ") for topic, text in home.said if topic != "end")
    verdict = examine(Check("MQTT broker", lambda: command._broker(settings)))
    assert verdict.level == "bad"
    assert "(connection refused): check that the program runs there" in verdict.sentence


def test_the_doctor_says_which_command_does_not_arrive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`wax doctor` names a command that does not arrive at a broker that accepts the connection."""
    monkeypatch.setattr(probes, "LIMIT_S", 0.2)
    acl = Acl(tmp_path)
    acl.allow("write wax/#", "read wax/wax/+/set", "write homeassistant/#")
    with running(tmp_path, *acl.lines) as mosquitto:
        mqtt = {"url": f"mqtt://localhost:{mosquitto.port}", **acl.keys}
        settings = Settings.model_validate({"mqtt": mqtt})
        verdict = examine(Check("MQTT broker", lambda: command._broker(settings)))
        assert verdict.level == "ok"
        rights = "readwrite wax/#", "write homeassistant/#"
        acl.allow("deny wax/wax/open/set", *rights, broker=mosquitto)
        verdict = examine(Check("MQTT broker", lambda: command._broker(settings)))
        assert verdict.level == "bad"
        assert "wax/wax/open/set" in verdict.sentence
        assert "stop" not in verdict.sentence


def test_the_doctor_says_what_may_not_be_written(tmp_path: Path) -> None:
    """`wax doctor` names each such topic, discovery's and a state's, as the host's panel does."""
    acl = Acl(tmp_path)
    acl.allow("deny wax/wax/queue", "deny wax/wax/event", "readwrite wax/#")
    with running(tmp_path, *acl.lines) as mosquitto:
        mqtt = {"url": f"mqtt://localhost:{mosquitto.port}", **acl.keys}
        settings = Settings.model_validate({"mqtt": mqtt})
        verdict = examine(Check("MQTT broker", lambda: command._broker(settings)))
        topics = "homeassistant/device/wax_wax/config, wax/wax/event, wax/wax/queue"
        values = {"topics": topics, "why": "Not authorized"}
        assert verdict.level == "bad"
        assert verdict.sentence == str(Sentence("house.not_said", values))


@pytest.mark.parametrize(
    ("limit", "n_left"), [("max_inflight_messages 3", 3), ("max_qos 1", 5), ("max_qos 2", 0)]
)
def test_no_more_is_asked_than_a_broker_allows(tmp_path: Path, limit: str, n_left: int) -> None:
    """A broker ends a connection for too many messages under way, or for QoS 2 if it has none."""
    with running(tmp_path, limit) as mosquitto:
        assert _link(mosquitto.port).check([f"rover/{number}" for number in range(5)]) == n_left


def test_the_doctor_neither_stops_nor_replaces_a_server(tmp_path: Path) -> None:
    """`wax doctor` neither stops nor disconnects a running server with the same topics."""
    with (
        running(tmp_path) as mosquitto,
        AtHome(mosquitto.port) as home,
        _linked(mosquitto.port) as link,
    ):
        until(lambda: home.value("rover/status") == "online")
        _link(mosquitto.port).check()
        until(lambda: _heard(home, link))
        assert {payload for _, payload, _ in link.taken} == {b"NOW"}
        assert ("rover/status", "offline") not in home.said


@contextmanager
def _answering(server: socket.socket, *texts: bytes) -> Iterator[list[bytes]]:
    """Answer each read of one connection with the next text; yield the list of what was read."""
    heard: list[bytes] = []

    def answer() -> None:
        with server.accept()[0] as line:
            for text in texts:
                heard.append(line.recv(1000))
                line.sendall(text)

    thread = threading.Thread(target=answer)
    thread.start()
    yield heard
    thread.join(5)
