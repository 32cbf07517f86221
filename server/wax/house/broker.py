"""The connection to the broker, in a thread of its own: nothing of the server waits for it.

paho looks names up, shakes hands and reads for as long as the other end takes; in the event loop
that would be everybody's delay, and Stop's too. It speaks MQTT 5, whose brokers send nothing larger
than they are asked to, and no retained copies where nobody wants them; one that does is left.
"""

from __future__ import annotations

import selectors
import ssl
import threading
from collections import deque
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

import structlog
from paho.mqtt import client as paho
from paho.mqtt.enums import CallbackAPIVersion, MQTTErrorCode
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.subscribeoptions import SubscribeOptions

from wax.errors import StartError, WaxError, reason_of
from wax.folders import expanded
from wax.hooks.post import not_reached
from wax.house.discovery import OFFLINE, ONLINE, STATUS
from wax.logs.printable import printable
from wax.named_file import read_bytes, read_secret
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from paho.mqtt.reasoncodes import ReasonCode

    from wax.clock import Clock
    from wax.config.mqtt import MqttSettings

_LOG = structlog.get_logger(__name__)

LIMIT_S: Final = 10.0
"""How long a broker may take to accept a connection."""
KEEPALIVE_S: Final = 15
"""A broker that hangs is left after twice this; it tells of us that we are gone after 1.5 times."""
MOST_BYTES: Final = 1024
MOST_EVENTS: Final = 200
MOST_PER_S: Final = 2000
"""Reading more would take the interpreter from the event loop, and with it from driving."""
_READS: Final = 4
"""What the largest message takes: its kind, its length in two bytes, the rest."""
KEPT_S: Final = 60.0
"""Old events would switch something that has long been otherwise; states are what lasts."""
_FIRST_WAIT_S: Final = 1.0
_LONGEST_WAIT_S: Final = 30.0
_LOOP_S: Final = 0.1
_MOST_CHARS: Final = 120
_MOST_HELD: Final = 20
"""Messages that the broker may have begun and not finished (QoS 2), which paho keeps."""
_MOST_PASSWORD_CHARS: Final = 1000
_PORTS: Final = {"mqtt": 1883, "mqtts": 8883}


class BrokerError(WaxError):
    """What keeps this server from its broker, in a sentence for the host."""


class BrokerLink:
    """Tries for ever; `StartError` if what it needs on this machine cannot be read.

    `states` are what each topic says now: whoever sets them replaces all of them. `asks` are the
    topics whose messages are given to `take`, in this thread: topic, payload, whether it is a
    retained copy. `problem` is why there is no connection, None while there is one. `lost` counts
    the events that were too many, `expired` those that were too old.
    """

    def __init__(
        self,
        settings: MqttSettings,
        clock: Clock,
        *,
        topic: str,
        asks: Sequence[str],
        take: Callable[[str, bytes, bool], None],
    ) -> None:
        parts = urlsplit(settings.url)
        self.name = parts.netloc
        self.states: Mapping[str, str] = {}
        self.problem: Sentence | None = None
        self.is_connected = False
        self.lost = self.expired = 0
        self._host, self._port = str(parts.hostname), parts.port or _PORTS[parts.scheme]
        self._user, self._password = settings.user, _password(settings.password_file)
        self._tls = _tls(settings.ca_file) if parts.scheme == "mqtts" else None
        self._clock = clock
        self._topic = topic
        self._asks = asks
        self._take = take
        self._refusal: ReasonCode | None = None
        self._said: dict[str, str] = {}
        self._events: deque[tuple[float, str]] = deque(maxlen=MOST_EVENTS)
        most = MOST_PER_S * _READS
        self._read_s: deque[float] = deque([float("-inf")] * most, maxlen=most)
        self._ended = threading.Event()
        # A daemon: a name server that hangs must not keep the process.
        self._thread = threading.Thread(target=self._run, name="mqtt", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self, limit_s: float) -> None:
        """Tell the broker that this ends; waits so long at most, and for none that is away."""
        self._ended.set()
        if self.is_connected:
            self._thread.join(limit_s)

    def put(self, event: str) -> None:
        """Have an event published soon; of too many the oldest is lost."""
        self.lost += len(self._events) == MOST_EVENTS
        self._events.append((self._clock.now_s(), event))

    def check(self) -> None:
        """Connect once and leave; raises `BrokerError`."""
        try:
            self._reach().disconnect()
        except (BrokerError, OSError) as error:
            raise BrokerError(_why(error)) from error

    def _run(self) -> None:
        failures = 0
        while not self._ended.is_set():
            try:
                self._serve(self._reach())
            except Exception as error:  # paho's too: driving does not need it
                why = _why(error)
                if why != self.problem:
                    _LOG.warning("no connection to the MQTT broker", broker=self.name, why=str(why))
                self.problem = why
            failures = 1 if self.is_connected else min(failures + 1, 10)
            self.is_connected = False
            self._ended.wait(min(_FIRST_WAIT_S * 2 ** (failures - 1), _LONGEST_WAIT_S))

    def _reach(self) -> paho.Client:
        """Return a client that the broker accepts and hears; raises `BrokerError` or `OSError`."""
        client = _Client(self._before_read)
        client.connect_timeout = LIMIT_S
        client.on_connect = self._accepted
        client.on_subscribe = self._subscribed
        client.on_message = self._arrived
        client.will_set(f"{self._topic}/{STATUS}", OFFLINE, qos=1, retain=True)
        if self._user:
            client.username_pw_set(self._user, self._password)
        if self._tls is not None:
            client.tls_set_context(self._tls)
        asked = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]  # paho's
        asked.MaximumPacketSize = MOST_BYTES
        asked.ReceiveMaximum = _MOST_HELD
        self._refusal = None
        client.connect(self._host, self._port, KEEPALIVE_S, properties=asked)
        end_s = self._clock.now_s() + LIMIT_S
        while not self.is_connected:
            if self._clock.now_s() > end_s:
                raise TimeoutError
            self._step(client)
        return client

    def _serve(self, client: paho.Client) -> None:
        """Publish and listen until the end; raises what ends it before."""
        self._said.clear()
        _LOG.info("connected to the MQTT broker", broker=self.name)
        while not self._ended.is_set():
            self._step(client)
            self._say(client)
        self._say(client)
        client.publish(f"{self._topic}/{STATUS}", OFFLINE, retain=True)
        client.disconnect()

    def _step(self, client: paho.Client) -> None:
        """Read and write what there is; paho's own `loop` would need a descriptor below 1,024."""
        line: Any = client.socket()
        code = paho.MQTT_ERR_CONN_LOST
        if line is not None:
            wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if client.want_write() else 0)
            with selectors.DefaultSelector() as waiting:
                waiting.register(line, wanted)
                waiting.select(0 if self._tls is not None and line.pending() else _LOOP_S)
            code = client.loop_read() or client.loop_write() or client.loop_misc()
        if self._refusal is not None:
            raise BrokerError(Sentence("house.refused", {"why": str(self._refusal)}))
        if code != paho.MQTT_ERR_SUCCESS:
            raise BrokerError(_lost(code))

    def _say(self, client: paho.Client) -> None:
        """Publish what is new, as far as the broker takes it: what it does not take waits here."""
        for topic, payload in ({f"{self._topic}/{STATUS}": ONLINE} | dict(self.states)).items():
            if client.want_write():
                return
            if self._said.get(topic) != payload:
                client.publish(topic, payload, retain=True)
                self._said[topic] = payload
        while self._events and not client.want_write():
            at_s, event = self._events.popleft()
            if self._clock.now_s() - at_s > KEPT_S:
                self.expired += 1
            else:
                client.publish(f"{self._topic}/event", event)

    def _accepted(
        self, client: paho.Client, _data: Any, _flags: Any, answer: ReasonCode, _more: Any
    ) -> None:
        if answer.is_failure:
            self._refusal = answer
            return
        options = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
        client.subscribe([(topic, options) for topic in self._asks])

    def _subscribed(
        self, _client: paho.Client, _data: Any, _mid: int, answers: list[ReasonCode], _more: Any
    ) -> None:
        """Be connected if no topic is kept from us: else a Stop at home would do nothing."""
        self._refusal = next((one for one in answers if one.is_failure), None)
        if self._refusal is None:
            self.problem = None
            self.is_connected = True

    def _arrived(self, _client: paho.Client, _data: Any, message: paho.MQTTMessage) -> None:
        self._take(message.topic, bytes(message.payload), message.retain)

    def _before_read(self, n_bytes: int) -> None:
        """Raise `BrokerError` where too much comes at once; what came before has acted."""
        if n_bytes > MOST_BYTES:
            raise BrokerError(_lost(paho.MQTT_ERR_PROTOCOL))
        now_s, before_s = self._clock.now_s(), self._read_s[0]
        self._read_s.append(now_s)
        if now_s - before_s < 1:
            raise BrokerError(Sentence("house.flooded", {"n": MOST_PER_S}))


class _Client(paho.Client):
    """paho's, which tells how much it is about to read.

    By itself it takes what a broker announces, up to 256 MB of one packet, and holds it all.
    """

    def __init__(self, before_read: Callable[[int], None]) -> None:
        super().__init__(
            CallbackAPIVersion.VERSION2, protocol=paho.MQTTv5, reconnect_on_failure=False
        )
        self._before_read = before_read

    def _sock_recv(self, bufsize: int) -> bytes:
        self._before_read(bufsize)
        return super()._sock_recv(bufsize)


def _lost(code: MQTTErrorCode) -> Sentence:
    return Sentence("house.lost", {"why": paho.error_string(code).rstrip(".").lower()})


def _why(error: Exception) -> Sentence:
    if isinstance(error, BrokerError):
        return error.sentence
    if isinstance(error, ssl.SSLCertVerificationError):
        return Sentence("house.certificate", {"why": printable(error.verify_message, _MOST_CHARS)})
    if isinstance(error, OSError):
        return not_reached(error, LIMIT_S)
    return says(printable(repr(error), _MOST_CHARS))


def _password(path: str) -> str | None:
    if not path:
        return None
    try:
        password = read_secret(path).decode().strip()
    except (OSError, UnicodeDecodeError) as error:
        why = reason_of(error)
        raise StartError(f"mqtt.password_file: {path} cannot be read: {why}") from error
    if not password:
        raise StartError(f"mqtt.password_file: {path} is empty; write the password into it")
    if len(password) > _MOST_PASSWORD_CHARS:
        raise StartError(
            f"mqtt.password_file: {path} holds more than {_MOST_PASSWORD_CHARS} characters; is it"
            " the right file?"
        )
    return password


def _tls(ca_file: str) -> ssl.SSLContext:
    path = expanded(ca_file) if ca_file else None
    try:
        if path is not None:
            read_bytes(path)  # OpenSSL would wait for a pipe, and read a device without end
        context = ssl.create_default_context(cafile=path)
        if path is not None:  # from Python 3.13 on, most that a host makes by hand are refused
            context.verify_flags &= ~ssl.VERIFY_X509_STRICT
        return context
    except OSError as error:  # an SSLError, too
        why = reason_of(error)
        raise StartError(f"mqtt.ca_file: {ca_file} holds no certificate: {why}") from error
