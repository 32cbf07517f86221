"""Seeded inputs that resemble valid ones.

Hypothesis shrinks its findings, but takes longer to draw an input than these parsers take to refuse
it, and ten thousand for each would not fit into the tests' time. Here an input costs 10 µs, and
corpus and seeds are those of the coverage-guided search.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from random import Random

_CHANGES: Final = (0, 1, 1, 1, 1, 2, 2, 3, 6)
"""How many changes an input gets: few, since most text formats are refused at the first one."""
_FROM_NOTHING: Final = 0.03
_LONGEST_PIECE: Final = 64
_BYTES: Final = bytes((0, 1, 0x7F, 0x80, 0xFE, 0xFF)) + b" \t\r\n\"'[]{}\\,:;=-+.%*#09aZ"
_WHOLE: Final = (-1, 0, 1, 127, 255, 256, 65_535, 65_536, 2**31, 2**32, 2**53 + 1, 2**64)
_NUMBERS: Final = (
    *(str(number).encode() for number in _WHOLE),
    *(b"1e999", b"NaN", b"null", b"9" * 400, b"0.1e-400"),
)


class Mutator:
    """Draws inputs of at most `max_bytes` from `seeds`, with `words` inserted."""

    def __init__(
        self, random: Random, seeds: Sequence[bytes], words: Sequence[bytes], max_bytes: int
    ) -> None:
        self._random = random
        self._seeds = list(seeds)
        self._words = [*words, *_NUMBERS]
        self._max_bytes = max_bytes
        self._ways: tuple[Callable[[bytearray], None], ...] = (
            self._flip,
            self._set,
            self._remove,
            self._repeat,
            self._put_word,
            self._put_noise,
            self._splice,
            self._number,
            self._number,
            self._number,
            self._cut,
        )

    def draw(self) -> bytes:
        """Return the next input: a valid one with a few changes, sometimes with none."""
        random = self._random
        data = bytearray(random.choice(self._seeds) if random.random() > _FROM_NOTHING else b"")
        for _ in range(random.choice(_CHANGES)):
            random.choice(self._ways)(data)
        return bytes(data[: self._max_bytes])

    def _place(self, data: bytearray) -> tuple[int, int]:
        """Return where a piece begins and ends; empty at the end of empty data."""
        begin = self._random.randrange(len(data) + 1)
        return begin, min(len(data), begin + self._random.randint(1, _LONGEST_PIECE))

    def _flip(self, data: bytearray) -> None:
        if data:
            data[self._random.randrange(len(data))] ^= 1 << self._random.randrange(8)

    def _set(self, data: bytearray) -> None:
        if data:
            data[self._random.randrange(len(data))] = self._random.choice(_BYTES)

    def _remove(self, data: bytearray) -> None:
        begin, end = self._place(data)
        del data[begin:end]

    def _repeat(self, data: bytearray) -> None:
        begin, end = self._place(data)
        data[begin:begin] = data[begin:end] * self._random.choice((1, 1, 2, 30))

    def _put_word(self, data: bytearray) -> None:
        begin, end = self._place(data)
        data[begin : self._random.choice((begin, end))] = self._random.choice(self._words)

    def _put_noise(self, data: bytearray) -> None:
        begin, end = self._place(data)
        noise = self._random.randbytes(self._random.randint(1, _LONGEST_PIECE))
        data[begin : self._random.choice((begin, end))] = noise

    def _splice(self, data: bytearray) -> None:
        other = bytearray(self._random.choice(self._seeds))
        begin, end = self._place(other)
        at, _ = self._place(data)
        data[at:at] = other[begin : self._random.choice((end, len(other)))]

    def _number(self, data: bytearray) -> None:
        """Change a whole number, which most checks are about."""
        found = [at for at, byte in enumerate(data) if 0x30 <= byte <= 0x39]
        if not found:
            return
        begin = end = self._random.choice(found)
        while begin > 0 and 0x30 <= data[begin - 1] <= 0x39:
            begin -= 1
        while end < len(data) and 0x30 <= data[end] <= 0x39:
            end += 1
        data[begin:end] = self._random.choice(_NUMBERS)

    def _cut(self, data: bytearray) -> None:
        del data[self._random.randrange(len(data) + 1) :]
