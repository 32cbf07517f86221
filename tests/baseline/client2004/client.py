"""The audio client of 4.3.2 and 5.2: a network thread, a queue, and a card that reads from it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from tests.baseline.client2004.source import SharedMemory

if TYPE_CHECKING:
    from collections.abc import Callable
    from random import Random

    from tests.baseline.client2004.path import Path
    from tests.baseline.client2004.source import Recorder, Server

    Serve = Callable[[list[float]], Server]
    """Makes a server from the times at which its MUs are ready."""

_ROUNDING_MS: Final = 1e-6
_AHEAD_MS: Final = 1000.0
"""The recording is longer than the listening by this; no client's request takes so long."""


@dataclass(frozen=True, slots=True)
class Client:
    """`block_ms`: what Java's audio reads at once; `queue_mus`: the queue, in audio MUs.

    The network thread asks for the next MU from `least_turn_ms` to `most_turn_ms` after it has put
    the last one into the queue.
    """

    least_turn_ms: float = 0.0
    most_turn_ms: float = 0.0
    block_ms: float = 50.0
    queue_mus: float = 2


@dataclass(slots=True)
class Heard:
    """The result. A pause is (start, length), in ms; `given` and `skipped` are as in `Server`."""

    seconds: float
    pauses: list[tuple[float, float]] = field(default_factory=list)
    blocks: int = 0
    given: list[tuple[int, float]] = field(default_factory=list)
    skipped: list[int] = field(default_factory=list)

    @property
    def pauses_per_s(self) -> float:
        return len(self.pauses) / self.seconds

    @property
    def pauses_per_block(self) -> float:
        """Return the pauses per amount of sound, the axis of the thesis's figures."""
        return len(self.pauses) / self.blocks

    @property
    def longest_ms(self) -> float:
        return max((length for _, length in self.pauses), default=0.0)

    @property
    def silence(self) -> float:
        """Return the share of the time that was pause."""
        return sum(length for _, length in self.pauses) / (self.seconds * 1000)


class Listening:
    """Plays for `seconds` after the first `from_s`, whose pauses and blocks do not count.

    Two threads with a queue between them are modelled as events in the order of their times. The
    card plays one block and asks for the next when that begins. So a read that takes no longer than
    a block is inaudible; a longer one is a pause (5.2.1.2).
    """

    def __init__(
        self,
        *,
        mu_ms: float,
        recorder: Recorder,
        path: Path,
        client: Client,
        chance: Random,
        seconds: float,
        from_s: float = 0.0,
        serve: Serve = SharedMemory,
    ) -> None:
        self._mu_ms = mu_ms
        self._path = path
        self._client = client
        self._chance = chance
        self._from_ms = from_s * 1000
        self._until_ms = (from_s + seconds) * 1000
        count = math.ceil((self._until_ms + _AHEAD_MS) / mu_ms)
        self._server = serve(recorder.ready_ms(mu_ms, count))
        self._heard = Heard(seconds)
        self._queued_ms = 0.0
        self._in_hand_ms = 0.0
        """The MU that the network thread has but the queue has no room for."""
        self._dry_ms: float | None = None
        """When the card will have played all that it has; None before its first block."""
        # The applet may be opened at any moment between two fragments of the card.
        self._arrives_ms = 0.0
        self._ask(chance.uniform(0.0, max(recorder.fragment_ms, mu_ms)))
        self._reads_ms = 0.0
        self._is_reading = False

    def run(self) -> Heard:
        while (now_ms := min(self._arrives_ms, self._reads_ms)) <= self._until_ms:
            if self._arrives_ms <= self._reads_ms:
                self._in_hand_ms = self._mu_ms
                self._arrives_ms = math.inf
            else:
                self._is_reading = True
                self._reads_ms = math.inf
            while self._write(now_ms) or self._read(now_ms):
                pass
        self._played_until(self._until_ms)
        self._heard.given, self._heard.skipped = self._server.given, self._server.skipped
        return self._heard

    def _ask(self, now_ms: float) -> None:
        """Request the next MU: half the delay is the way there, half the way back."""
        half_ms = self._path.delay_ms(now_ms, self._chance) / 2
        leaves_ms = self._server.answer_ms(now_ms + half_ms)
        self._arrives_ms = math.inf if leaves_ms is None else leaves_ms + half_ms

    def _played_until(self, now_ms: float) -> None:
        """Record the pause that lasts until now, if there is one, from where it counts."""
        if self._dry_ms is not None:
            began_ms = max(self._dry_ms, self._from_ms)
            if now_ms > began_ms + _ROUNDING_MS:
                self._heard.pauses.append((began_ms, now_ms - began_ms))

    def _write(self, now_ms: float) -> bool:
        room_ms = self._client.queue_mus * self._mu_ms - self._queued_ms
        moved_ms = min(room_ms, self._in_hand_ms)
        if moved_ms <= 0:
            return False
        self._queued_ms += moved_ms
        self._in_hand_ms -= moved_ms
        if self._in_hand_ms <= 0:
            turn_ms = self._chance.uniform(self._client.least_turn_ms, self._client.most_turn_ms)
            self._ask(now_ms + turn_ms)
        return True

    def _read(self, now_ms: float) -> bool:
        if not self._is_reading or self._queued_ms <= 0:
            return False
        block_ms = min(self._client.block_ms, self._queued_ms)
        self._queued_ms -= block_ms
        self._is_reading = False
        self._played_until(now_ms)
        self._heard.blocks += now_ms >= self._from_ms
        starts_ms = now_ms if self._dry_ms is None else max(now_ms, self._dry_ms)
        self._dry_ms = starts_ms + block_ms
        self._reads_ms = starts_ms
        return True
