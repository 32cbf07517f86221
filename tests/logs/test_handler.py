"""Logging never blocks, even if its lines cannot be written."""

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
    """A pipe with a handler at one end; a test reads the other end when it wants to."""

    def __init__(self) -> None:
        self.reader, self.writer = os.pipe()
        self.handler = QueuedHandler(self.writer)

    def log(self, *lines: object) -> None:
        for line in lines:
            record = logging.LogRecord("wax", logging.INFO, "", 0, line, (), None)
            self.handler.handle(record)

    def read(self, until: str) -> list[str]:
        """Read lines up to one with these words."""
        text = b""
        while not (text.endswith(b"\n") and until.encode() in text.splitlines()[-1]):
            text += os.read(self.reader, 65_536)
        return text.decode().splitlines()

    def close(self) -> None:
        os.close(self.reader)  # this frees a thread that is stuck in a write
        self.handler.close()
        os.close(self.writer)


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    pipe = Pipe()
    yield pipe
    pipe.close()


@pytest.mark.timeout(20)
def test_lines_come_whole_and_in_order(pipe: Pipe) -> None:
    """Each line is written whole before the next, however long it is."""
    pipe.log("one", LONG, "three")
    assert pipe.read("three") == ["one", LONG, "three"]


@pytest.mark.timeout(20)
def test_nobody_waits_for_a_reader(pipe: Pipe) -> None:
    """Logging goes on while nobody reads; afterwards a line counts those dropped."""
    pipe.log(LONG, *range(3 * MAX_WAITING))
    *lines, last = pipe.read("missing")
    told = re.match(r"(\d+) log lines are missing", last)
    assert told is not None
    assert lines[0] == LONG
    numbers = [int(line) for line in lines[1:]]
    # One later line may fit in, depending on when the thread takes the long line.
    assert numbers[: MAX_WAITING - 1] == list(range(MAX_WAITING - 1))
    assert numbers == sorted(set(numbers))
    assert len(lines) - 1 + int(told[1]) == 3 * MAX_WAITING
    assert MAX_WAITING <= len(lines) <= MAX_WAITING + 1
    pipe.log("and on")
    assert pipe.read("and on") == ["and on"]


@pytest.mark.timeout(20)
def test_what_is_missing_is_told_each_time_anew(pipe: Pipe) -> None:
    """Each count has only the lines dropped since the last one."""
    for _ in range(2):
        pipe.log(LONG, *range(MAX_WAITING + 7))
        missing = int(pipe.read("missing")[-1].split()[0])
        assert missing in {7, 8}


@pytest.mark.timeout(20)
def test_the_end_writes_what_is_left(pipe: Pipe) -> None:
    """`close` waits for the last lines."""
    pipe.log(*range(100))
    pipe.handler.close()
    assert pipe.read("99") == [str(number) for number in range(100)]


@pytest.mark.timeout(20)
def test_the_end_does_not_wait_for_a_reader_for_ever(pipe: Pipe) -> None:
    """`close` returns even if nobody reads, the second time too."""
    pipe.log(LONG)
    pipe.handler.close()
    pipe.handler.close()


@pytest.mark.timeout(20)
def test_a_reader_that_is_gone_is_no_fault(pipe: Pipe) -> None:
    """Lines to a closed pipe are discarded, and `close` returns."""
    reader, pipe.reader = pipe.reader, os.open(os.devnull, os.O_RDONLY)
    os.close(reader)
    pipe.log("one", LONG)
    pipe.handler.close()


@pytest.mark.timeout(20)
def test_a_descriptor_that_does_not_block_gets_all(pipe: Pipe) -> None:
    """A non-blocking descriptor, as another program may leave a terminal, loses no line."""
    os.set_blocking(pipe.writer, False)
    pipe.log(LONG, "last")
    assert pipe.read("last") == [LONG, "last"]


@pytest.mark.timeout(20)
def test_what_cannot_be_written_is_told(pipe: Pipe) -> None:
    """Wrong format arguments and lone surrogates are logged as such, and logging goes on."""

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
    """An object that logs when it is collected, within another log call, causes no deadlock."""

    class Last:
        def __str__(self) -> str:
            pipe.log("inner")
            return "outer"

    pipe.log(Last())
    assert pipe.read("outer") == ["inner", "outer"]


def test_what_is_printed_becomes_lines() -> None:
    """A printed line is logged when it ends or is very long; an empty one is not."""
    lines: list[str] = []
    stream = PrintedLines(lines.append)
    print("one\n\ntwo", 3, file=stream)
    print("four", end="", file=stream)
    assert lines == ["one", "two 3"]
    print("teen", file=stream)
    print("." * 10_001, end="", flush=True, file=stream)
    print("rest", file=stream)
    assert lines[2:] == ["fourteen", "." * 10_001, "rest"]
