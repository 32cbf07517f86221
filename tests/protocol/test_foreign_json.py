"""JSON of strangers: its size, values and levels are counted before anything parses it."""

from __future__ import annotations

import pytest
from pydantic import BaseModel

from wax.errors import ProtocolError
from wax.protocol import foreign_json

MOST = 65_536


class _Parser:
    """Counts what it is given."""

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self, _data: bytes) -> None:
        self.asked += 1


@pytest.mark.parametrize(
    "data",
    [
        b"{" + b",".join(b'"%x":1' % n for n in range(6800)) + b"}",
        b'{"a":[' + b",".join([b"[]"] * 21_000) + b"]}",
        b'{"a":[' + b",".join([b"1"] * 32_000) + b"]}",
        b'{"a":' + b"[" * 65_000,
        b" " * (MOST + 1),
        "ä" * (MOST // 2 + 1),
    ],
)
def test_what_no_message_has_is_refused_unparsed(data: bytes | str) -> None:
    """Thousands of keys, values or levels, and whatever is longer in bytes than it may be."""
    parser = _Parser()
    with pytest.raises(ProtocolError):
        foreign_json.read(data, MOST, parser)
    assert parser.asked == 0


def test_the_first_error_is_short() -> None:
    """A key that is unknown is named, but not repeated in all its length."""

    class Empty(BaseModel, extra="forbid"):
        pass

    for key, says in (("b", "b: Extra"), ("b" * 9000, "b…: Extra"), ("\\n", r"\\n: Extra")):
        with pytest.raises(ProtocolError, match=says) as caught:
            foreign_json.read(f'{{"{key}":1,"c":2}}', MOST, Empty.model_validate_json)
        assert len(str(caught.value)) < 500
