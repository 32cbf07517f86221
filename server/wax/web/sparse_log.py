"""Rate-limits the log lines that strangers cause: a few a minute, whatever they do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from wax.rate_limits import TokenBucket

if TYPE_CHECKING:
    from structlog.typing import FilteringBoundLogger

    from wax.clock import Clock

_BURST: Final = 5
_EVERY_S: Final = 10.0
_LONGEST_CHARS: Final = 200


class SparseLog:
    """Passes on a burst of lines and then one every 10 s, with the number of those left out."""

    def __init__(self, log: FilteringBoundLogger, clock: Clock) -> None:
        self._log = log
        self._clock = clock
        self._bucket = TokenBucket(rate_hz=1 / _EVERY_S, burst=_BURST)
        self._left_out = 0

    def info(self, event: str, **values: Any) -> None:
        """Log one line; texts are shortened, and escaped unless they are printable ASCII."""
        if not self._bucket.take(self._clock.now_s()):
            self._left_out += 1
            return
        shown = {name: _short(value) for name, value in values.items()}
        if self._left_out:
            shown["left_out"] = self._left_out
        self._left_out = 0
        self._log.info(event, **shown)


def _short(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    printable = value if value.isprintable() and value.isascii() else ascii(value)
    return printable[:_LONGEST_CHARS]
