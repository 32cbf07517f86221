"""Structured logs, and counters for the status page."""

from __future__ import annotations

import logging
import sys
from collections import Counter
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import structlog

from wax.logs import limits
from wax.logs.handler import QueuedHandler

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from structlog.typing import Processor

    from wax.config.log import LogSettings


_STANDARD_ERROR: Final = 2


class Counters:
    """Named counts that only rise, such as ``refused.not your turn``. Event loop only."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()

    def add(self, name: str, count: int = 1) -> None:
        self._counts[name] += count

    def snapshot(self) -> dict[str, int]:
        return dict(sorted(self._counts.items()))


@contextmanager
def quiet_logs() -> Iterator[None]:
    """Log only errors within the block, to standard error: for commands that print results."""
    before = structlog.get_config()
    structlog.configure(
        wrapper_class=structlog.make_filtering_bound_logger(logging.ERROR),
        logger_factory=structlog.PrintLoggerFactory(sys.stderr),
    )
    try:
        yield
    finally:
        structlog.configure(**before)


def configure_logs(settings: LogSettings) -> None:
    """Send our logs, and the warnings of Python and the libraries, to standard error.

    `logging.shutdown`, which Python calls on exit, writes the remaining lines.
    """
    is_open = sys.stderr is not None  # otherwise another file may have its descriptor by now
    renderer: Processor = (
        structlog.processors.JSONRenderer()
        if settings.format == "json"
        else structlog.dev.ConsoleRenderer(colors=is_open and sys.stderr.isatty())
    )
    shared: list[Processor] = [
        structlog.stdlib.add_log_level,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        structlog.processors.format_exc_info,
    ]
    structlog.configure(
        processors=[
            structlog.stdlib.filter_by_level,
            *shared,
            structlog.stdlib.ProcessorFormatter.wrap_for_formatter,
        ],
        logger_factory=structlog.stdlib.LoggerFactory(),
        cache_logger_on_first_use=True,
    )
    handler = QueuedHandler(_STANDARD_ERROR) if is_open else logging.NullHandler()
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=shared,
            processors=[
                limits.add_left_out,
                structlog.stdlib.ProcessorFormatter.remove_processors_meta,
                limits.tidy,
                renderer,
            ],
        )
    )
    handler.addFilter(limits.RepeatLimit())
    root = logging.getLogger()
    root.handlers = [handler]
    root.setLevel(logging.WARNING)
    logging.getLogger("wax").setLevel(settings.level.upper())
    logging.captureWarnings(True)


class CountRates:
    """Computes rates per second of rising counts, from occasional samples."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[float, int]] = {}
        self._rates_hz: dict[str, float] = {}

    def sample(self, counts: Mapping[str, int], now_s: float) -> None:
        """Sample all counts at once; a rate needs at least two samples."""
        for name, count in counts.items():
            then_s, before = self._last.get(name, (now_s, count))
            if now_s > then_s:
                self._rates_hz[name] = round((count - before) / (now_s - then_s), 1)
            self._last[name] = (now_s, count)

    def hz(self, name: str) -> float:
        return self._rates_hz.get(name, 0.0)
