"""Encodes messages as rows, for a narrow uplink.

A row is the JSON array of a message's fields in the order of its model, with a nested model as a
nested row: ``["ping",3,1234.5,null,null]``. Only the model defines the order. A sender may leave
out the last fields, where the model has defaults for them.
"""

from __future__ import annotations

import functools
import json
from typing import Any, Final, TypeAlias, get_args

import pydantic_core
from pydantic import BaseModel

from wax.errors import ProtocolError

Columns: TypeAlias = "dict[str, Columns | None]"
"""Field names in order, each with the columns of its nested model, or None for a plain value."""

_TIME_DECIMALS: Final = 1
"""The decimals of times in ms: browser clocks are no finer."""


@functools.cache
def columns(model: type[BaseModel]) -> Columns:
    """Return the columns of a model's row."""
    return {name: _inner(field.annotation) for name, field in model.model_fields.items()}


def by_type(*models: type[BaseModel]) -> dict[str, Columns]:
    """Return the columns of each model by its `type`."""
    return {get_args(one.model_fields["type"].annotation)[0]: columns(one) for one in models}


def write(message: BaseModel) -> str:
    """Return a message as a row, with times rounded to 0.1 ms."""
    row = _row(message.model_dump(), columns(type(message)))
    return json.dumps(row, separators=(",", ":"))


def read(data: str | bytes, table: dict[str, Columns]) -> dict[str, Any]:
    """Return a row's values by name, not validated; raises `ProtocolError`."""
    try:
        row = pydantic_core.from_json(data, allow_inf_nan=False)
    except ValueError as error:
        raise ProtocolError(f"not JSON: {error}") from error
    kind = row[0] if isinstance(row, list) and row else None
    if not isinstance(kind, str) or kind not in table:
        raise ProtocolError("not a row of a known type")
    return _named(row, table[kind], kind)


def _inner(annotation: Any) -> Columns | None:
    for one in (annotation, *get_args(annotation)):
        if isinstance(one, type) and issubclass(one, BaseModel):
            return columns(one)
    return None


def _row(values: dict[str, Any], of: Columns) -> list[Any]:
    return [_cell(name, values[name], inner) for name, inner in of.items()]


def _cell(name: str, value: Any, inner: Columns | None) -> Any:
    if inner is not None and value is not None:
        return _row(value, inner)
    is_time = isinstance(value, float) and name.endswith("_ms")
    return round(value, _TIME_DECIMALS) if is_time else value


def _named(row: Any, of: Columns, name: str) -> dict[str, Any]:
    if not isinstance(row, list) or len(row) > len(of):
        raise ProtocolError(f"{name}: not a row of at most {len(of)}")
    return {
        name: value if inner is None or value is None else _named(value, inner, name)
        for (name, inner), value in zip(of.items(), row, strict=False)
    }
