"""Values written as TOML."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.config.as_toml import as_toml

_LEAVES = (
    st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False)
    | st.text(st.characters(exclude_categories=["Cs"]))
)


@examples(200)
@given(
    st.recursive(
        _LEAVES,
        lambda inner: (
            st.lists(inner, max_size=9)
            | st.dictionaries(st.text(st.characters(exclude_categories=["Cs"])), inner, max_size=4)
        ),
    )
)
def test_what_is_written_is_read(value: Any) -> None:
    """TOML's own reader finds every value as it was."""
    assert tomllib.loads(f"key = {as_toml(value)}")["key"] == value


@pytest.mark.parametrize(
    ("value", "written"),
    [
        (115_200, "115_200"),
        (8080, "8080"),
        (40022, "40022"),
        ([{"a": 1}], "[{ a = 1 }]"),
        ([{"some_longer_name": 1}] * 3, "[\n" + "    { some_longer_name = 1 },\n" * 3 + "]"),
    ],
)
def test_people_can_read_it(value: object, written: str) -> None:
    """Large round numbers have groups of digits, and many tables a line for each."""
    assert as_toml(value) == written


def test_what_toml_lacks_is_refused() -> None:
    """There is no null in TOML, so None raises."""
    with pytest.raises(TypeError):
        as_toml({"key": None})
