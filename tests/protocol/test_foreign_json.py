"""Strangers' JSON: its size, values and nesting are bounded before it is parsed."""

from __future__ import annotations

import pytest
from pydantic import BaseModel

from wax.errors import ProtocolError
from wax.protocol import foreign_json

MOST = 65_536


class _Parser:
    """A fake parser that counts its calls."""

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
    """Too many keys, values, levels or bytes are refused without a call of the parser."""
    parser = _Parser()
    with pytest.raises(ProtocolError):
        foreign_json.read(data, MOST, parser)
    assert parser.asked == 0


def test_the_first_error_is_short() -> None:
    """An unknown key is named in the error, cut to a bound."""

    class Empty(BaseModel, extra="forbid"):
        pass

    for key, says in (("b", "b: Extra"), ("b" * 9000, "b…: Extra"), ("\\n", r"\\n: Extra")):
        with pytest.raises(ProtocolError, match=says) as caught:
            foreign_json.read(f'{{"{key}":1,"c":2}}', MOST, Empty.model_validate_json)
        assert len(str(caught.value)) < 500
