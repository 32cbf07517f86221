"""Logs with one line for each event, in the configured format; and rates from counts."""

from __future__ import annotations

import json
import logging
import sys
import warnings
from typing import TYPE_CHECKING

import pytest
import structlog
from structlog.testing import capture_logs

from wax.config.log import LogSettings
from wax.telemetry import Counters, CountRates, configure_logs, quiet_logs

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(autouse=True)
def _logs_as_before() -> Iterator[None]:
    root = logging.getLogger()
    handlers, level = root.handlers, root.level
    yield
    for handler in root.handlers:
        if handler not in handlers:
            handler.close()
    root.handlers = handlers
    root.setLevel(level)
    logging.captureWarnings(False)
    structlog.reset_defaults()


def test_json_logs_are_one_object_a_line(capfd: pytest.CaptureFixture[str]) -> None:
    """Each event is one JSON object with its time, level and values; libraries' warnings too."""
    configure_logs(LogSettings(format="json"))
    structlog.get_logger("wax.test").info("viewer connected", viewer=3)
    logging.getLogger("aiortc").warning("odd packet")
    logging.getLogger().handlers[0].close()  # which waits until all is written
    first, second = map(json.loads, capfd.readouterr().err.splitlines())
    assert (first["event"], first["viewer"], first["level"]) == ("viewer connected", 3, "info")
    assert first["timestamp"].endswith("Z")
    assert (second["event"], second["level"]) == ("odd packet", "warning")


def test_no_value_reaches_the_terminal_raw(capfd: pytest.CaptureFixture[str]) -> None:
    """Values of our logs, libraries' and exceptions are escaped and cut; a flood is limited."""
    configure_logs(LogSettings(format="text"))
    log = structlog.get_logger("wax.test")
    log.info("renamed", name="\x1b]0;evil\x07\u202e" + "x" * 1000)
    logging.getLogger("aioice").warning("candidate %s", "\x1b[2J")
    try:
        raise ValueError("\x1b[2J")
    except ValueError:
        log.exception("failed")
    for _ in range(300):
        log.info("flood")
    logging.getLogger().handlers[0].close()
    text = capfd.readouterr().err
    assert not set("\x1b\x07\u202e") & set(text)
    assert r"\x1b]0;evil\x07\u202e" in text
    assert max(map(len, text.splitlines())) < 500
    assert text.count("flood") == 100


def test_warnings_of_python_are_logs(capfd: pytest.CaptureFixture[str]) -> None:
    """Python's warnings are log lines, and do not wait for a reader either."""
    configure_logs(LogSettings(format="json"))
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        logging.captureWarnings(False)
        logging.captureWarnings(True)  # pytest had put its own recorder there
        warnings.warn("old", DeprecationWarning, stacklevel=1)
    logging.getLogger().handlers[0].close()
    (line,) = map(json.loads, capfd.readouterr().err.splitlines())
    assert "DeprecationWarning: old" in line["event"]


def test_a_closed_standard_error_gets_nothing(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A closed standard error gets nothing: its descriptor may be the robot's serial line."""
    monkeypatch.setattr(sys, "stderr", None)
    configure_logs(LogSettings())
    structlog.get_logger("wax.test").warning("for nobody")
    logging.getLogger().handlers[0].close()
    assert capfd.readouterr() == ("", "")


def test_text_logs_and_the_level(capfd: pytest.CaptureFixture[str]) -> None:
    """Text logs are one readable line each; lines below the level are not written."""
    configure_logs(LogSettings(format="text", level="warning"))
    structlog.get_logger("wax.test").info("small")
    structlog.get_logger("wax.test").warning("large", size=2)
    logging.getLogger().handlers[0].close()  # which waits until all is written
    lines = capfd.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "large" in lines[0]
    assert "size=2" in lines[0]


def test_counters_add_up() -> None:
    """Counts rise by name, and a snapshot is sorted."""
    counters = Counters()
    counters.add("b")
    counters.add("a", 2)
    counters.add("b")
    assert list(counters.snapshot().items()) == [("a", 2), ("b", 2)]


def test_rates_need_two_samples() -> None:
    """A rate is the difference of two samples divided by the time between them."""
    rates = CountRates()
    rates.sample({"frames": 10}, 1.0)
    assert rates.hz("frames") == 0.0
    rates.sample({"frames": 70}, 3.0)
    assert rates.hz("frames") == 30.0
    assert rates.hz("unknown") == 0.0


def test_a_command_that_says_itself_what_it_finds(capsys: pytest.CaptureFixture[str]) -> None:
    """Within `quiet_logs`, warnings are not printed and errors go to standard error."""
    log = structlog.get_logger("wax")
    with quiet_logs():
        log.warning("a warning")
        log.error("an error")
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "an error" in shown.err
    assert "a warning" not in shown.err
    with capture_logs() as logs:
        log.warning("again")
    assert len(logs) == 1
