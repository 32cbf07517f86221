"""One connection to a broker, by MQTT 5.

It limits the size of what the broker sends and asks for no retained commands; it disconnects from a
broker that exceeds the limit.
"""

from __future__ import annotations

import selectors
from collections import deque
from typing import TYPE_CHECKING, Any, Final

from paho.mqtt import client as paho
from paho.mqtt.enums import CallbackAPIVersion, MQTTErrorCode
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode
from paho.mqtt.subscribeoptions import SubscribeOptions

from wax.errors import WaxError
from wax.house.discovery import OFFLINE, ONLINE
from wax.house.probes import Probes
from wax.house.publications import MOST_AWAITED, MOST_PACKET_BYTES, Publications
from wax.house.troubles import not_said, troubles
from wax.sentence import Sentence

if TYPE_CHECKING:
    import ssl
    from collections.abc import Callable, Mapping, Sequence

    from paho.mqtt.client import DisconnectFlags

    from wax.clock import Clock

KEEPALIVE_S: Final = 15
"""We disconnect from a hung broker after twice this; a broker sends our will after 1.5 times."""
MOST_BYTES: Final = 2048
"""A probe of Stop has 1,024 and its topic."""
MOST_PER_S: Final = 2000
"""Reading more would take the interpreter from the event loop, and with it from driving."""
_READS: Final = 4
"""The reads that the largest message takes: its type, two bytes of length, the rest."""
AGAIN_S: Final = 10.0
"""How often what was refused or overwritten is published again; everything, at most as often."""
_CORRECTED_S: Final = 1.0
_LOOP_S: Final = 0.1
_MOST_HELD: Final = 20
"""Messages the broker may have in flight to us (QoS 2): paho keeps each until it is complete."""
_MARK: Final = "wax-server"
"""The user property of a status that names the process that published it."""
_NOT_AUTHORIZED: Final = 0x87
_OLD: Final = "Unsupported protocol version"
_TAKEN_OVER: Final = 0x8E


class BrokerError(WaxError):
    """Why this server cannot use its broker, in a sentence for the host."""


class BrokerConnection:
    """Belongs to one thread; `asks`, `deliver` and the `birth` of `listen` are `BrokerLink`'s.

    The client id is constant, so a new connection ends an old one that the broker still holds:
    otherwise the broker would send the old one's will after we are back. `rival` says that another
    server has ended ours so: `mark` is the name of this process, `is_return` whether it has been
    connected before. `may_listen` is false if the broker ended the connection because of `listen`.
    """

    def __init__(
        self,
        client_id: str,
        clock: Clock,
        *,
        mark: str,
        is_return: bool,
        status: str,
        asks: Mapping[str, str],
        deliver: Callable[[str, bytes, bool], None],
        login: tuple[str, str | None] | None,
        tls: ssl.SSLContext | None,
    ) -> None:
        self.client = _Client(client_id, self._before_read)
        self.client.on_connect = self._on_connect
        self.client.on_subscribe = self._on_subscribe
        self.client.on_message = self._on_message
        self.client.on_disconnect = self._on_disconnect
        if login is not None:
            self.client.username_pw_set(*login)
        if tls is not None:
            self.client.tls_set_context(tls)
        self.publications = Publications(self.client)
        self.rival: Sentence | None = None
        self.may_listen = True
        self._id, self._mark, self._clock = client_id, mark, clock
        self._is_return = is_return
        self._status, self._asks, self._deliver = status, asks, deliver
        self._tls = tls
        self._probes = Probes(asks)
        self._is_accepted = self._is_subscribed = False
        self._end: Sentence | None = None
        self._birth = ""
        self._listening: int | None = None
        self._wrong_s: float | None = None
        self._is_born = False
        self._again_s = self._corrected_s = self._all_s = float("-inf")
        most = MOST_PER_S * _READS
        self._read_s: deque[float] = deque([float("-inf")] * most, maxlen=most)

    def set_will(self) -> None:
        """Set the will, by which the broker publishes that this server is gone."""
        marked = self._marked(PacketTypes.WILLMESSAGE)
        self.client.will_set(self._status, OFFLINE, 1, retain=True, properties=marked)

    def open(self, host: str, port: int, limit_s: float) -> None:
        """Connect, subscribe and probe each command topic; closed if it raises.

        Raises `BrokerError` or `OSError`.
        """
        try:
            self._open(host, port, limit_s)
        except BaseException:
            self.close()
            raise

    def _open(self, host: str, port: int, limit_s: float) -> None:
        self.client.connect_timeout = limit_s
        asked = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]  # paho's
        asked.MaximumPacketSize = MOST_BYTES
        asked.ReceiveMaximum = _MOST_HELD
        self.client.connect(host, port, KEEPALIVE_S, properties=asked)
        end_s = self._clock.now_s() + limit_s
        while not self._is_subscribed:
            if self._clock.now_s() > end_s:
                raise TimeoutError
            self.step()
        while not self._probes.are_tried():
            self.step()

    def listen(self, birth: str) -> None:
        """Subscribe to what is useful but not needed: our own status and, if not empty, `birth`."""
        self._birth = birth
        heard = [(self._status, SubscribeOptions(qos=1)), *([(birth, _live())] if birth else [])]
        _, self._listening = self.client.subscribe(heard)

    def step(self) -> None:
        """Read and write what is ready; paho's own `loop` needs a descriptor below 1,024."""
        client = self.client
        line: Any = client.socket()
        code = paho.MQTT_ERR_CONN_LOST
        if line is not None:
            wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if client.want_write() else 0)
            with selectors.DefaultSelector() as waiting:
                waiting.register(line, wanted)
                waiting.select(0 if self._tls is not None and line.pending() else _LOOP_S)
            code = client.loop_read() or client.loop_write() or client.loop_misc()
        now_s = self._clock.now_s()
        if self.publications.awaited_s(now_s) > 2 * KEEPALIVE_S:
            code = paho.MQTT_ERR_KEEPALIVE
        if self._end is not None:
            raise BrokerError(self._end)
        if code != paho.MQTT_ERR_SUCCESS and not self._is_accepted:
            raise ConnectionAbortedError  # `explained` finds out why
        if code != paho.MQTT_ERR_SUCCESS:
            raise BrokerError(_lost(paho.error_string(code)))
        for topic, payload in self._probes.due(now_s) if self._is_subscribed else ():
            if self.publications.can_send():
                self.publications.publish(topic, payload, now_s)

    def ask_to_write(self, topics: Sequence[str]) -> int:
        """Ask about each topic, as many as the broker allows, and return how many that were.

        One by one: a broker may answer by ending the connection.
        """
        asked = topics[: self.publications.most_questions]
        for topic in asked:
            self.publications.ask_to_write(topic, self._clock.now_s())
            while self.publications.awaited():
                self.step()
        return len(asked)

    def publish_states(self, states: Mapping[str, str]) -> None:
        """Publish what has changed: which command topics work, that we are online, and `states`."""
        now_s, publications = self._clock.now_s(), self.publications
        if now_s - self._again_s >= AGAIN_S:
            self._again_s = now_s
            publications.forget(publications.refused)
            publications.forget([] if self._wrong_s is None else [self._status])
        if self._is_born and now_s - self._all_s >= AGAIN_S:
            self._is_born, self._all_s = False, now_s
            publications.forget_all()
        ways = {
            told: ONLINE if self._probes.is_open(topic) else OFFLINE
            for topic, told in self._asks.items()
        }
        for topic, payload in (ways | {self._status: ONLINE} | dict(states)).items():
            if not publications.can_send():
                return
            marked = self._marked(PacketTypes.PUBLISH) if topic == self._status else None
            publications.publish_state(topic, payload, now_s, marked)

    def disconnect(self) -> None:
        """Publish "offline" and disconnect."""
        marked = self._marked(PacketTypes.PUBLISH)
        self.client.publish(self._status, OFFLINE, retain=True, properties=marked)
        self.client.disconnect()

    def close(self) -> None:
        """Close the socket, which paho would leave to the garbage collector."""
        line: Any = self.client.socket()
        if line is not None:
            line.close()

    def troubles(self) -> list[Sentence]:
        """Return the problems of this connection to show to the host."""
        said = self.publications
        closed = [topic for topic in self._probes.closed() if topic not in said.too_large]
        found = troubles(self._asks, closed, said.refused)
        for is_command in (False, True):
            left_out = [one for one in said.too_large if (one in self._asks) is is_command]
            if left_out:
                found.append(
                    Sentence(
                        "house.not_tried" if is_command else "house.too_large",
                        {"topics": ", ".join(sorted(left_out)), "most": said.most_bytes},
                    )
                )
        if self._wrong_s is not None and self._clock.now_s() - self._wrong_s > AGAIN_S:
            found.append(Sentence("house.not_kept", {"topic": self._status}))
        return found

    def _on_connect(
        self, client: paho.Client, _data: Any, _flags: Any, answer: ReasonCode, more: Any
    ) -> None:
        if answer.is_failure:
            is_old = str(answer) == _OLD
            refused = Sentence("house.refused", {"why": str(answer)})
            self._end = Sentence("house.old") if is_old else refused
            return
        self._is_accepted = True
        self.publications.limit(
            getattr(more, "ReceiveMaximum", MOST_AWAITED),
            getattr(more, "MaximumPacketSize", MOST_PACKET_BYTES),
            getattr(more, "MaximumQoS", 2),
        )
        client.subscribe([(topic, _live()) for topic in self._asks])

    def _on_subscribe(
        self, _client: paho.Client, _data: Any, mid: int, answers: list[ReasonCode], _more: Any
    ) -> None:
        """Fail if the broker refuses any command topic: a Stop at home would do nothing."""
        if mid == self._listening:
            self._listening = None
            return
        refusal = next((one for one in answers if one.is_failure), None)
        self._is_subscribed = refusal is None
        if refusal is not None:
            self._end = Sentence("house.refused", {"why": str(refusal)})

    def _on_disconnect(
        self, _client: paho.Client, _data: Any, flags: DisconnectFlags, why: ReasonCode, _more: Any
    ) -> None:
        """Note why the broker disconnects us; some do so instead of refusing one topic."""
        if not flags.is_disconnect_packet_from_server:
            return
        unanswered = self.publications.awaited()
        self._end = _lost(str(why))
        if why.value == _TAKEN_OVER:  # mosquitto 2.0 does not say so
            self._end = self.rival = self._rival_problem()
        elif why.value == _NOT_AUTHORIZED and self._listening is not None:
            self.may_listen = False
        elif why.value == _NOT_AUTHORIZED and unanswered:
            self._end = not_said(unanswered, why)

    def _on_message(self, _client: paho.Client, _data: Any, message: paho.MQTTMessage) -> None:
        topic, payload, now_s = message.topic, bytes(message.payload), self._clock.now_s()
        if topic == self._status:
            said_by = dict(getattr(message.properties, "UserProperty", [])).get(_MARK, self._mark)
            is_online, is_live = payload == ONLINE.encode(), not message.retain
            if said_by != self._mark and (is_online if is_live else self._is_return):
                self.rival = self._rival_problem()
            self._check_status(is_online=is_online, is_live=is_live, now_s=now_s)
        elif topic == self._birth:
            self._is_born |= payload == ONLINE.encode() and not message.retain
        elif not self._probes.consume(topic, payload, now_s):
            self._deliver(topic, payload, message.retain)

    def _check_status(self, *, is_online: bool, is_live: bool, now_s: float) -> None:
        """Publish "online" again where an old will, or somebody else, has said "offline"."""
        if is_online:
            self._wrong_s = None
            return
        self._wrong_s = now_s if self._wrong_s is None else self._wrong_s
        if is_live and now_s - self._corrected_s >= _CORRECTED_S:
            self._corrected_s = now_s
            self.publications.forget([self._status])

    def _rival_problem(self) -> Sentence:
        return Sentence("house.taken_over", {"client": self._id})

    def _marked(self, packet: int) -> Properties:
        made = Properties(packet)  # type: ignore[no-untyped-call]  # paho's
        made.UserProperty = [(_MARK, self._mark)]
        return made

    def _before_read(self, n_bytes: int) -> None:
        """Raise `BrokerError` if a message or the rate is too large; earlier ones have acted."""
        if n_bytes > MOST_BYTES:
            raise BrokerError(_lost(paho.error_string(paho.MQTT_ERR_PROTOCOL)))
        now_s, before_s = self._clock.now_s(), self._read_s[0]
        self._read_s.append(now_s)
        if now_s - before_s < 1:
            raise BrokerError(Sentence("house.flooded", {"n": MOST_PER_S}))


class _Client(paho.Client):
    """paho's client, which asks `before_read` before each read, and releases nothing (QoS 2).

    On its own, it buffers whatever length a broker announces, up to 256 MB for one packet.
    """

    def __init__(self, client_id: str, before_read: Callable[[int], None]) -> None:
        super().__init__(
            CallbackAPIVersion.VERSION2,
            client_id,
            protocol=paho.MQTTv5,
            reconnect_on_failure=False,
        )
        self._before_read = before_read

    def _sock_recv(self, bufsize: int) -> bytes:
        self._before_read(bufsize)
        return super()._sock_recv(bufsize)

    def _handle_pubrec(self) -> MQTTErrorCode:
        """Report the broker's answer; paho would release the message even after a refusal."""
        packet = self._in_packet["packet"]
        mid = int.from_bytes(packet[:2])
        if mid not in self._out_messages:
            return MQTTErrorCode.MQTT_ERR_SUCCESS
        answer = ReasonCode(PacketTypes.PUBREC, identifier=packet[2] if len(packet) > 2 else 0)
        return self._do_on_publish(mid, answer, Properties(PacketTypes.PUBREC))  # type: ignore[no-untyped-call]


def _live() -> SubscribeOptions:
    """Return the options of a subscription without retained copies."""
    return SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)


def _lost(why: str) -> Sentence:
    return Sentence("house.lost", {"why": why.rstrip(".").lower()})
