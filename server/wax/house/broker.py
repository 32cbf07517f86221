"""The link to the broker, in a thread of its own so that nothing else waits for it.

paho blocks on name lookups, handshakes and reads; in the event loop that would delay every viewer,
and Stop.
"""

from __future__ import annotations

import secrets
import threading
from collections import deque
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

import structlog

from wax.authority import client_tls
from wax.errors import StartError
from wax.house.connection import BrokerConnection, BrokerError
from wax.house.discovery import EVENT, STATUS
from wax.house.slug import client_id
from wax.logs.printable import printable
from wax.named_file import told_text
from wax.second_look import explained
from wax.sentence import Sentence, says
from wax.unreachable import CLOSED, Target

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from wax.clock import Clock
    from wax.config.mqtt import MqttSettings

_LOG = structlog.get_logger(__name__)

LIMIT_S: Final = 10.0
"""How long a broker may take to accept a connection."""
MOST_EVENTS: Final = 200
KEPT_S: Final = 60.0
"""An older event would trigger an automation about what has since changed; states are current."""
_FIRST_WAIT_S: Final = 1.0
_LONGEST_WAIT_S: Final = 30.0
RIVAL_S: Final = 60.0
"""How long the host sees that a rival took our client id; returning sooner would start a fight."""
_MOST_CHARS: Final = 120
_MOST_PASSWORD_CHARS: Final = 1000


class BrokerLink:
    """Retries for ever; raises `StartError` if a file that it needs cannot be read.

    `states` maps each topic to its current payload; assign it as a whole. `asks` maps each command
    topic to the topic that says whether its commands arrive. A command is passed to `deliver`, in
    this thread: topic, payload, whether it is a retained copy. "online" at the topic `birth` has
    everything published again.

    `is_connected` is true once each command topic has been probed. `problem` is why there is no
    connection, None while there is one; `troubles` is what the broker refuses or withholds. `lost`
    counts the events dropped from a full queue, `expired` those that were too old.
    """

    def __init__(
        self,
        settings: MqttSettings,
        clock: Clock,
        *,
        topic: str,
        asks: Mapping[str, str],
        birth: str,
        deliver: Callable[[str, bytes, bool], None],
    ) -> None:
        parts = urlsplit(settings.url)
        self.name = parts.netloc
        self.states: Mapping[str, str] = {}
        self.problem: Sentence | None = None
        self.troubles: Sequence[Sentence] = ()
        self.is_connected = False
        self.lost = self.expired = 0
        target = Target.of(
            settings.url, LIMIT_S, ca_key="[mqtt] ca_file", has_ca=bool(settings.ca_file)
        )
        assert target is not None, "the configuration takes no other address"
        self._target = target
        self._user, self._password = settings.user, _password(settings.password_file)
        self._tls = (
            client_tls(settings.ca_file, "mqtt.ca_file") if parts.scheme == "mqtts" else None
        )
        self._clock = clock
        self._topic = topic
        self._asks = asks
        self._birth = birth
        self._deliver = deliver
        self._may_listen = True
        self._mark, self._is_return = secrets.token_hex(8), False
        self._rival: tuple[float, Sentence] | None = None
        self._is_fight = False
        self._events: deque[tuple[float, str]] = deque(maxlen=MOST_EVENTS)
        self._ended = threading.Event()
        # A daemon: a name server that hangs must not keep the process alive.
        self._thread = threading.Thread(target=self._run, name="mqtt", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self, limit_s: float) -> None:
        """Disconnect; wait at most `limit_s`, and not at all for a broker that is away."""
        self._ended.set()
        if self.is_connected:
            self._thread.join(limit_s)

    def put(self, event: str) -> None:
        """Enqueue an event; a full queue drops its oldest."""
        self.lost += len(self._events) == MOST_EVENTS
        self._events.append((self._clock.now_s(), event))

    def check(self, topics: Sequence[str] = ()) -> int:
        """Connect once, probe each command topic, and ask whether `topics` may be written.

        Returns how many of them the broker lets nobody ask about; raises `BrokerError`. It has a
        client id of its own and no will: a running server keeps its session, and nobody at home
        notices.
        """
        connection = self._connection("trial")
        try:
            connection.open(self._target.host, self._target.port, LIMIT_S)
            n_asked = connection.ask_to_write(topics)
            connection.client.disconnect()
        except (BrokerError, OSError) as error:
            raise BrokerError(self._why(error)) from error
        finally:
            connection.close()
        if found := connection.troubles():
            raise BrokerError(" ".join(str(one) for one in found))
        return len(topics) - n_asked

    def _why(self, error: Exception) -> Sentence:
        if isinstance(error, BrokerError):
            return error.sentence
        if not isinstance(error, OSError):
            return says(printable(repr(error), _MOST_CHARS))
        told = explained(self._target, error)
        return Sentence("house.no_mqtt", {"at": self._target.at}) if told.code == CLOSED else told

    def _run(self) -> None:
        failures = 0
        while not self._ended.is_set():
            self._is_fight = False
            try:
                self._serve(self._reach())
            except Exception as error:  # a bug of paho's, too: driving does not depend on it
                why = self._why(error)
                if why != self.problem:
                    _LOG.warning("no connection to the MQTT broker", broker=self.name, why=str(why))
                self.problem, self.troubles = why, ()
            failures = 1 if self.is_connected else min(failures + 1, 10)
            self.is_connected = False
            wait_s = min(_FIRST_WAIT_S * 2 ** (failures - 1), _LONGEST_WAIT_S)
            self._ended.wait(_LONGEST_WAIT_S if self._is_fight else wait_s)

    def _reach(self) -> BrokerConnection:
        """Return an open connection; raises as `BrokerConnection.open` does."""
        connection = self._connection("server")
        connection.set_will()
        connection.open(self._target.host, self._target.port, LIMIT_S)
        self.problem, self.is_connected, self._is_return = None, True, True
        return connection

    def _connection(self, use: str) -> BrokerConnection:
        return BrokerConnection(
            client_id(self._topic, use),
            self._clock,
            mark=self._mark,
            is_return=self._is_return,
            status=f"{self._topic}/{STATUS}",
            asks=self._asks,
            deliver=self._deliver,
            login=(self._user, self._password) if self._user else None,
            tls=self._tls,
        )

    def _serve(self, connection: BrokerConnection) -> None:
        """Publish and listen until closed; raises whatever ends the connection first."""
        _LOG.info("connected to the MQTT broker", broker=self.name)
        try:
            if self._may_listen:
                connection.listen(self._birth)
            while not self._ended.is_set():
                connection.step()
                self._publish(connection)
                self._update_troubles(connection)
        except BrokerError:
            self._note_end(connection)
            raise
        else:
            self._publish(connection)
            connection.disconnect()
        finally:
            connection.close()

    def _publish(self, connection: BrokerConnection) -> None:
        """Publish changed states and queued events, as many as the broker accepts now."""
        connection.publish_states(self.states)
        while self._events and connection.publications.can_send():
            at_s, event = self._events.popleft()
            now_s = self._clock.now_s()
            if now_s - at_s > KEPT_S:
                self.expired += 1
            else:
                connection.publications.publish(f"{self._topic}/{EVENT}", event, now_s)

    def _update_troubles(self, connection: BrokerConnection) -> None:
        """Update what the broker refuses or withholds, and log what is new."""
        self._note_rival(connection)
        found = connection.troubles()
        if self._rival is not None and self._has_rival():
            found.append(self._rival[1])
        for one in found:
            if one not in self.troubles:
                _LOG.warning(
                    "something is wrong at the MQTT broker", broker=self.name, why=str(one)
                )
        self.troubles = found

    def _note_end(self, connection: BrokerConnection) -> None:
        self._may_listen &= connection.may_listen
        self._is_fight = self._has_rival()
        self._note_rival(connection)

    def _note_rival(self, connection: BrokerConnection) -> None:
        if connection.rival is not None:
            self._rival, connection.rival = (self._clock.now_s(), connection.rival), None

    def _has_rival(self) -> bool:
        return self._rival is not None and self._clock.now_s() - self._rival[0] < RIVAL_S


def _password(path: str) -> str | None:
    if not path:
        return None
    password = told_text("mqtt.password_file", path, "; it holds the password")
    if len(password) > _MOST_PASSWORD_CHARS:
        raise StartError(
            f"mqtt.password_file: {path} holds more than {_MOST_PASSWORD_CHARS} characters; is it"
            " the right file?"
        )
    return password
