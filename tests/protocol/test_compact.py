"""Rows of the drive channel: compact, and as strict as objects."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from wax.errors import ProtocolError
from wax.protocol import compact, messages

VECTORS = json.loads((Path(__file__).parents[1] / "vectors" / "drive.json").read_text("utf-8"))

SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)
TYPES = st.sampled_from([*messages.DRIVE_COLUMNS, "fly"])


@pytest.mark.parametrize("vector", VECTORS["to_server"], ids=lambda one: one["row"])
def test_a_row_of_the_page_becomes_its_message(vector: dict[str, Any]) -> None:
    """The rows that the page writes, by its own test, are read as the same messages."""
    assert messages.parse_drive(vector["row"]).model_dump(exclude_unset=True) == vector["message"]
    assert (
        messages.parse_drive(vector["row"].encode()).model_dump(exclude_unset=True)
        == vector["message"]
    )


@pytest.mark.parametrize("vector", VECTORS["to_page"], ids=lambda one: one["row"])
def test_a_message_to_the_page_becomes_its_row(vector: dict[str, Any]) -> None:
    """The rows written are those that the page reads, by its own test."""
    message = TypeAdapter[Any](messages.DriveOut).validate_python(vector["message"])
    assert compact.write(message) == vector["row"]


@pytest.mark.parametrize("row", VECTORS["refused"])
def test_what_is_no_row_is_refused(row: str) -> None:
    """A wrong length or type, an object or an invalid number raises `ProtocolError`."""
    with pytest.raises(ProtocolError):
        messages.parse_drive(row)


def test_a_long_row_is_not_even_read() -> None:
    """A row beyond the limit is refused by its bytes, before it is parsed."""
    ping = '["ping",1,100,null,null]'
    messages.parse_drive(ping + " " * (messages.MAX_DRIVE_BYTES - len(ping)))
    with pytest.raises(ProtocolError, match="longer"):
        messages.parse_drive(ping + " " * (messages.MAX_DRIVE_BYTES + 1 - len(ping)))


@given(st.lists(st.recursive(SCALARS, st.lists, max_leaves=12), max_size=10), TYPES)
def test_any_row_is_a_message_or_refused(values: list[Any], kind: str) -> None:
    """Any row is a valid message or raises `ProtocolError`."""
    try:
        message = messages.parse_drive(json.dumps([kind, *values]))
    except ProtocolError:
        return
    assert isinstance(message, get_args(messages.DriveIn))
    assert message.type == kind


def test_times_are_written_to_a_tenth_of_a_millisecond() -> None:
    """Times are written with one decimal: browser clocks are no finer, and every byte counts."""
    pong = messages.Pong(id=1, sent_page_ms=1.25049, server_ms=99_999.9999, beat="x7-_2A")
    assert compact.write(pong) == '["pong",1,1.3,100000.0,"x7-_2A"]'
