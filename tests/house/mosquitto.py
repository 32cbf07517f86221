"""Debian's broker as a process for tests, and a client at home that listens and presses."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
from contextlib import contextmanager
from typing import TYPE_CHECKING, Self

import pytest
from paho.mqtt import client as paho
from paho.mqtt.enums import CallbackAPIVersion
from paho.mqtt.subscribeoptions import SubscribeOptions
from tests.free_port import free_port
from tests.until import until

if TYPE_CHECKING:
    import signal
    from collections.abc import Iterator
    from pathlib import Path

_SENTENCE = "mosquitto is missing; type: sudo apt-get install -y mosquitto"


def mosquitto() -> str:
    """Return the path of the broker's program; skip the test without it, except in CI."""
    found = shutil.which("mosquitto", path=f"{os.environ.get('PATH', '')}:/usr/sbin")
    if found is None:
        if os.environ.get("CI"):
            pytest.fail(_SENTENCE)
        pytest.skip(_SENTENCE)
    return found


class Mosquitto:
    """One broker on one port, which can be killed, stopped and started again."""

    def __init__(self, folder: Path, *lines: str) -> None:
        self.port = free_port()
        self._file = folder / "mosquitto.conf"
        # Started as root, it would switch to a user who cannot read the test's files.
        own = [f"listener {self.port} 127.0.0.1", "user root"]
        own += [] if any("allow_anonymous" in line for line in lines) else ["allow_anonymous true"]
        self._file.write_text("\n".join([*own, *lines, ""]))
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self._process = subprocess.Popen(
            [mosquitto(), "-c", str(self._file)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        until(self._listens)

    def signal(self, number: signal.Signals) -> None:
        assert self._process is not None
        self._process.send_signal(number)

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _listens(self) -> bool:
        with socket.socket() as tried:
            return tried.connect_ex(("127.0.0.1", self.port)) == 0


@contextmanager
def running(folder: Path, *lines: str) -> Iterator[Mosquitto]:
    broker = Mosquitto(folder, *lines)
    broker.start()
    try:
        yield broker
    finally:
        broker.kill()


class AtHome:
    """A client that records others' messages: each topic's newest, and whether it is retained.

    `said` has all messages, for those that may be replaced before a test looks.
    """

    def __init__(self, port: int) -> None:
        self.heard: dict[str, tuple[str, bool]] = {}
        self.said: list[tuple[str, str]] = []
        self.events: list[str] = []
        self._client = paho.Client(CallbackAPIVersion.VERSION2, protocol=paho.MQTTv5)
        self._client.on_message = self._on_message
        self._client.connect("127.0.0.1", port)
        self._client.subscribe("#", options=SubscribeOptions(qos=1, noLocal=True))
        self._client.loop_start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.disconnect()
        self._client.loop_stop()
        del self._client  # it closes its last socket when it is collected

    def says(self, topic: str, payload: str | bytes, *, retain: bool = False, qos: int = 1) -> None:
        info = self._client.publish(topic, payload, qos=qos, retain=retain)
        if qos:
            info.wait_for_publish(5)

    def value(self, topic: str) -> str | None:
        return self.heard.get(topic, (None, False))[0]

    def _on_message(self, _client: paho.Client, _data: object, message: paho.MQTTMessage) -> None:
        text = message.payload.decode(errors="replace")
        self.heard[message.topic] = (text, message.retain)
        self.said.append((message.topic, text))
        if message.topic.endswith("/event"):
            self.events.append(text)
