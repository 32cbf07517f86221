"""Logging never blocks, whatever becomes of the lines."""

from __future__ import annotations

import logging
import os
import re
from typing import TYPE_CHECKING

import pytest

from wax.logs.handler import MAX_WAITING, PrintedLines, QueuedHandler

if TYPE_CHECKING:
    from collections.abc import Iterator

LONG = "x" * 200_000
"""More than a pipe holds."""


class Pipe:
    """A pipe with a handler at its one end; the other is read only when the test says so."""

    def __init__(self) -> None:
        self.reader, self.writer = os.pipe()
        self.handler = QueuedHandler(self.writer)

    def log(self, *lines: object) -> None:
        for line in lines:
            record = logging.LogRecord("wax", logging.INFO, "", 0, line, (), None)
            self.handler.handle(record)

    def read(self, until: str) -> list[str]:
        """Read up to a line with these words."""
        text = b""
        while not (text.endswith(b"\n") and until.encode() in text.splitlines()[-1]):
            text += os.read(self.reader, 65_536)
        return text.decode().splitlines()

    def close(self) -> None:
        os.close(self.reader)  # which frees a thread that is stuck
        self.handler.close()
        os.close(self.writer)


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    pipe = Pipe()
    yield pipe
    pipe.close()


@pytest.mark.timeout(20)
def test_lines_come_whole_and_in_order(pipe: Pipe) -> None:
    """A line is written to its end before the next, however long it is."""
    pipe.log("one", LONG, "three")
    assert pipe.read("three") == ["one", LONG, "three"]


@pytest.mark.timeout(20)
def test_nobody_waits_for_a_reader(pipe: Pipe) -> None:
    """While nobody reads, logging goes on; afterwards the lines that are missing are counted."""
    pipe.log(LONG, *range(3 * MAX_WAITING))
    *lines, last = pipe.read("missing")
    told = re.match(r"(\d+) log lines are missing", last)
    assert told is not None
    assert lines[0] == LONG
    numbers = [int(line) for line in lines[1:]]
    # The thread takes the long line at a moment of its own; one later line may fit in then.
    assert numbers[: MAX_WAITING - 1] == list(range(MAX_WAITING - 1))
    assert numbers == sorted(set(numbers))
    assert len(lines) - 1 + int(told[1]) == 3 * MAX_WAITING
    assert MAX_WAITING <= len(lines) <= MAX_WAITING + 1
    pipe.log("and on")
    assert pipe.read("and on") == ["and on"]


@pytest.mark.timeout(20)
def test_what_is_missing_is_told_each_time_anew(pipe: Pipe) -> None:
    """The second count does not hold what the first has told."""
    for _ in range(2):
        pipe.log(LONG, *range(MAX_WAITING + 7))
        missing = int(pipe.read("missing")[-1].split()[0])
        assert missing in {7, 8}


@pytest.mark.timeout(20)
def test_the_end_writes_what_is_left(pipe: Pipe) -> None:
    """Closing waits for the last lines."""
    pipe.log(*range(100))
    pipe.handler.close()
    assert pipe.read("99") == [str(number) for number in range(100)]


@pytest.mark.timeout(20)
def test_the_end_does_not_wait_for_a_reader_for_ever(pipe: Pipe) -> None:
    """Where nobody reads, closing comes back all the same, also the second time."""
    pipe.log(LONG)
    pipe.handler.close()
    pipe.handler.close()


@pytest.mark.timeout(20)
def test_a_reader_that_is_gone_is_no_fault(pipe: Pipe) -> None:
    """Lines for nobody are thrown away, and the end comes as ever."""
    reader, pipe.reader = pipe.reader, os.open(os.devnull, os.O_RDONLY)
    os.close(reader)
    pipe.log("one", LONG)
    pipe.handler.close()


@pytest.mark.timeout(20)
def test_a_descriptor_that_does_not_block_gets_all(pipe: Pipe) -> None:
    """A terminal that another program has made non-blocking loses nothing."""
    os.set_blocking(pipe.writer, False)
    pipe.log(LONG, "last")
    assert pipe.read("last") == [LONG, "last"]


@pytest.mark.timeout(20)
def test_what_cannot_be_written_is_told(pipe: Pipe) -> None:
    """Neither words that do not fit their arguments nor half a character end the log."""

    class Broken:
        def __str__(self) -> str:
            raise ValueError("no words")

    pipe.log(Broken(), "\ud800", "last")
    *trace, half, last = pipe.read("last")
    assert trace[0].startswith("a log line cannot be written")
    assert "ValueError: no words" in trace
    assert (half, last) == ("\\ud800", "last")


@pytest.mark.timeout(20)
def test_what_is_collected_within_a_line_may_log(pipe: Pipe) -> None:
    """An object whose end logs while a line is being logged does not lock the log."""

    class Last:
        def __str__(self) -> str:
            pipe.log("inner")
            return "outer"

    pipe.log(Last())
    assert pipe.read("outer") == ["inner", "outer"]


def test_what_is_printed_becomes_lines() -> None:
    """Each line that is printed is logged once it ends, or once it is very long; empty ones not."""
    lines: list[str] = []
    stream = PrintedLines(lines.append)
    print("one\n\ntwo", 3, file=stream)
    print("four", end="", file=stream)
    assert lines == ["one", "two 3"]
    print("teen", file=stream)
    print("." * 10_001, end="", flush=True, file=stream)
    print("rest", file=stream)
    assert lines[2:] == ["fourteen", "." * 10_001, "rest"]
