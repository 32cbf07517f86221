"""The events as the host's programs read them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from wax.__main__ import main
from wax.protocol import events

if TYPE_CHECKING:
    import pytest

MANUAL = (Path(__file__).parents[2] / "config" / "wax.toml").read_text(encoding="utf-8")


def _types(model: Any) -> tuple[str, ...]:
    return get_args(model.model_fields["type"].annotation)


def test_the_manual_has_every_event_and_field() -> None:
    """The manual lists each event type with its fields, above `hook = []`."""
    before = MANUAL.partition("\nhook = []")[0]
    for model in events.MODELS:
        assert all(one in before for one in _types(model)), model
        for name in set(model.model_fields) - {"version", "timestamp", "type"}:
            assert f" {name}" in before, (model, name)


def test_the_schema_describes_every_event(capsys: pytest.CaptureFixture[str]) -> None:
    """`wax hook schema` prints each kind of event with its types, description and fields."""
    assert main(["hook", "schema"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert set(printed["discriminator"]["mapping"]) == {*events.NAMES, "hook.test"}
    for model in events.MODELS:
        described = printed["$defs"][model.__name__]
        assert described["description"].startswith(str(model.__doc__).split("\n", maxsplit=1)[0])
        assert set(described["required"]) == set(model.model_fields)


def test_an_event_is_one_flat_object() -> None:
    """An event has version, time, type and its own fields at one level."""
    began = events.TurnBegan(
        timestamp="2026-11-26T12:00:00.000+00:00", turn=3, viewer=7, name="Ada"
    )
    assert json.loads(began.model_dump_json()) == {
        "version": 1,
        "timestamp": "2026-11-26T12:00:00.000+00:00",
        "type": "turn.began",
        "turn": 3,
        "viewer": 7,
        "name": "Ada",
    }


def test_a_name_can_be_left_out() -> None:
    """`nameless` removes a person's name, and changes nothing else."""
    removed = events.Removed(type="viewer.banned", viewer=2, name="Eve")
    assert events.nameless(removed) == removed.model_copy(update={"name": None})
    kept = events.TapeKept(by="host")
    assert events.nameless(kept) is kept
