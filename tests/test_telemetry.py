"""Logs and figures: one line an event, in the form that was asked for; rates from counts."""

from __future__ import annotations

import json
import logging
from typing import TYPE_CHECKING

import pytest
import structlog

from wax.config import LogSettings
from wax.telemetry import Counters, Rates, configure_logs

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(autouse=True)
def _logs_as_before() -> Iterator[None]:
    root = logging.getLogger()
    handlers, level = root.handlers, root.level
    yield
    root.handlers = handlers
    root.setLevel(level)
    structlog.reset_defaults()


def test_json_logs_are_one_object_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    """Each event is one JSON object with its time, level and values; libraries' warnings too."""
    configure_logs(LogSettings(format="json"))
    structlog.get_logger("wax.test").info("viewer connected", viewer=3)
    logging.getLogger("aiortc").warning("odd packet")
    first, second = map(json.loads, capsys.readouterr().err.splitlines())
    assert (first["event"], first["viewer"], first["level"]) == ("viewer connected", 3, "info")
    assert first["timestamp"].endswith("Z")
    assert (second["event"], second["level"]) == ("odd packet", "warning")


def test_text_logs_and_the_level(capsys: pytest.CaptureFixture[str]) -> None:
    """Text is for people; what is below the level is not written."""
    configure_logs(LogSettings(format="text", level="warning"))
    structlog.get_logger("wax.test").info("small")
    structlog.get_logger("wax.test").warning("large", size=2)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "large" in lines[0]
    assert "size=2" in lines[0]


def test_counters_add_up() -> None:
    """Counts rise by name and are told in order."""
    counters = Counters()
    counters.add("b")
    counters.add("a", 2)
    counters.add("b")
    assert list(counters.snapshot().items()) == [("a", 2), ("b", 2)]


def test_rates_need_two_samples() -> None:
    """A rate is the growth between two samples by the time between them."""
    rates = Rates()
    rates.sample({"frames": 10}, 1.0)
    assert rates.hz("frames") == 0.0
    rates.sample({"frames": 70}, 3.0)
    assert rates.hz("frames") == 30.0
    assert rates.hz("unknown") == 0.0
