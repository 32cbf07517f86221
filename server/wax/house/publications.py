"""What one connection has published, and what of it the broker refused."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from paho.mqtt.properties import VariableByteIntegers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from paho.mqtt import client as paho
    from paho.mqtt.properties import Properties
    from paho.mqtt.reasoncodes import ReasonCode

MOST_AWAITED: Final = 20
"""The most messages that may await an acknowledgement; beyond them, publishing pauses."""
MOST_PACKET_BYTES: Final = 268_435_460
"""The largest packet where the broker names no limit (MQTT 5, 2.1.4)."""
_QUESTION: Final = "None"
"""Home Assistant's unknown state, in case a broker delivers before it is asked to."""


class Publications:
    """Publishes with QoS 1, since only then does a broker answer that a topic may not be written.

    `refused` maps the topics that it refused to why; `too_large` are those whose last message was
    not sent, since the broker ends a connection that sends a packet of more than `most_bytes`.
    `ask_to_write` may be called `most_questions` times.
    """

    def __init__(self, client: paho.Client) -> None:
        self.refused: dict[str, ReasonCode] = {}
        self.too_large: set[str] = set()
        self.most_bytes = MOST_PACKET_BYTES
        self.most_questions = 0
        self._client = client
        self._most = MOST_AWAITED
        self._said: dict[str, str] = {}
        self._awaited: dict[int, tuple[str, float]] = {}
        client.on_publish = self._on_publish

    def limit(self, n_awaited: int, most_bytes: int, most_qos: int) -> None:
        """Apply the broker's limits: messages under way, bytes of one packet, and its QoS."""
        self._most, self.most_bytes = min(MOST_AWAITED, n_awaited), most_bytes
        self.most_questions = self._most - 1 if most_qos == 2 else 0  # each stays under way

    def can_send(self) -> bool:
        """Whether the broker accepts another message now."""
        return len(self._awaited) < self._most and not self._client.want_write()

    def publish(self, topic: str, payload: str | bytes, now_s: float) -> None:
        """Publish a message that is not retained."""
        self._send(topic, payload, now_s, retain=False)

    def ask_to_write(self, topic: str, now_s: float) -> None:
        """Find out whether the broker takes a message at this topic, which reaches nobody.

        It answers with QoS 2 as with QoS 1, but brokers like mosquitto deliver only what is
        released, and `_Client` releases nothing.
        """
        self._send(topic, _QUESTION, now_s, retain=False, qos=2)

    def publish_state(
        self, topic: str, payload: str, now_s: float, properties: Properties | None = None
    ) -> None:
        """Publish a retained message, unless it equals the topic's last."""
        if self._said.get(topic) != payload:
            self._said[topic] = payload
            self._send(topic, payload, now_s, retain=True, properties=properties)

    def forget(self, topics: Iterable[str]) -> None:
        """Let `publish_state` publish these topics again."""
        for topic in topics:
            self._said.pop(topic, None)

    def forget_all(self) -> None:
        self._said.clear()

    def awaited(self) -> list[str]:
        """Return the topics that await an acknowledgement, the oldest first."""
        return list(dict.fromkeys(topic for topic, _ in self._awaited.values()))

    def awaited_s(self, now_s: float) -> float:
        """Return for how many seconds the oldest acknowledgement has been awaited."""
        return max((now_s - at_s for _, at_s in self._awaited.values()), default=0.0)

    def _send(
        self,
        topic: str,
        payload: str | bytes,
        now_s: float,
        *,
        retain: bool,
        qos: int = 1,
        properties: Properties | None = None,
    ) -> None:
        if _packet_bytes(topic, payload, properties) > self.most_bytes:
            self.too_large.add(topic)
            return
        self.too_large.discard(topic)
        sent = self._client.publish(topic, payload, qos, retain, properties)
        self._awaited[sent.mid] = topic, now_s

    def _on_publish(
        self, _client: paho.Client, _data: Any, mid: int, answer: ReasonCode, _more: Any
    ) -> None:
        topic, _ = self._awaited.pop(mid, (None, 0.0))
        if topic is None:
            return
        if answer.is_failure:
            self.refused[topic] = answer
        else:
            self.refused.pop(topic, None)


def _packet_bytes(topic: str, payload: str | bytes, properties: Properties | None) -> int:
    """Return the bytes of the whole PUBLISH packet (MQTT 5, 3.3)."""
    body = payload.encode() if isinstance(payload, str) else payload
    more = b"\0" if properties is None else properties.pack()  # type: ignore[no-untyped-call]
    rest = 2 + len(topic.encode()) + 2 + len(more) + len(body)
    return 1 + len(VariableByteIntegers.encode(rest)) + rest  # type: ignore[no-untyped-call]
