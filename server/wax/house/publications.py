"""What one connection has published, and what of it the broker does not take."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from paho.mqtt.properties import VariableByteIntegers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from paho.mqtt import client as paho
    from paho.mqtt.properties import Properties
    from paho.mqtt.reasoncodes import ReasonCode

MOST_AWAITED: Final = 20
"""Messages that the broker has not acknowledged; beyond them, what is to be said waits here."""
MOST_PACKET_BYTES: Final = 268_435_460
"""What every broker takes that names no limit (MQTT 5, 2.1.4)."""


class Publications:
    """With QoS 1, since only then a broker answers that a topic may not be written.

    `refused` are the topics of which it did, and why; `too_large` those of which the last message
    was left out, since the broker ends a connection that sends it more than `most_bytes` at once.
    """

    def __init__(self, client: paho.Client) -> None:
        self.refused: dict[str, ReasonCode] = {}
        self.too_large: set[str] = set()
        self.most_bytes = MOST_PACKET_BYTES
        self._client = client
        self._most = MOST_AWAITED
        self._said: dict[str, str] = {}
        self._awaited: dict[int, tuple[str, float]] = {}
        client.on_publish = self._answered

    def limit(self, n_awaited: int, most_bytes: int) -> None:
        """Keep to what the broker takes, in all and of one packet."""
        self._most, self.most_bytes = min(MOST_AWAITED, n_awaited), most_bytes

    def may(self) -> bool:
        """Whether the broker takes another message now."""
        return len(self._awaited) < self._most and not self._client.want_write()

    def publish(self, topic: str, payload: str | bytes, now_s: float) -> None:
        """Send what is not kept."""
        self._send(topic, payload, now_s, retain=False)

    def state(
        self, topic: str, payload: str, now_s: float, properties: Properties | None = None
    ) -> None:
        """Send what is kept, unless it was the last that was said there."""
        if self._said.get(topic) != payload:
            self._said[topic] = payload
            self._send(topic, payload, now_s, retain=True, properties=properties)

    def forget(self, topics: Iterable[str]) -> None:
        """Have `state` send these again."""
        for topic in topics:
            self._said.pop(topic, None)

    def forget_all(self) -> None:
        self._said.clear()

    def awaited(self) -> list[str]:
        """Return the topics of which no answer has come, the oldest first."""
        return list(dict.fromkeys(topic for topic, _ in self._awaited.values()))

    def awaited_s(self, now_s: float) -> float:
        """Return since when the oldest answer is awaited."""
        return max((now_s - at_s for _, at_s in self._awaited.values()), default=0.0)

    def _send(
        self,
        topic: str,
        payload: str | bytes,
        now_s: float,
        *,
        retain: bool,
        properties: Properties | None = None,
    ) -> None:
        if _packet_bytes(topic, payload, properties) > self.most_bytes:
            self.too_large.add(topic)
            return
        self.too_large.discard(topic)
        sent = self._client.publish(topic, payload, 1, retain, properties)
        self._awaited[sent.mid] = topic, now_s

    def _answered(
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
    """Return how long it is on its way (MQTT 5, 3.3)."""
    body = payload.encode() if isinstance(payload, str) else payload
    more = b"\0" if properties is None else properties.pack()  # type: ignore[no-untyped-call]
    rest = 2 + len(topic.encode()) + 2 + len(more) + len(body)
    return 1 + len(VariableByteIntegers.encode(rest)) + rest  # type: ignore[no-untyped-call]
