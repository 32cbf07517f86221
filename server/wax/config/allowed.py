"""Describe the allowed values of a configuration key, from the schema of its model.

Error messages and the manual `config/wax.toml` use the same words.
"""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any, Final

from pydantic import Field

if TYPE_CHECKING:
    from collections.abc import Sequence

Schema = dict[str, Any]
"""A JSON schema, as `BaseModel.model_json_schema` returns it."""

_LOGIN: Final = re.compile(r"(?<=://)\S*@")


def said(words: str, *, plural: str = "names") -> Any:
    """Return an annotation with the words for a type's values, and for a list of them."""
    return Field(json_schema_extra={"allowed": words, "plural": plural})


def printable(least: int, most: int, text: str = "a text", *, plural: str = "names") -> Any:
    """Return the annotation of a text of so many printable characters, with the words for it."""
    count = f"{least} to {most}" if least else f"at most {most}"
    return Field(
        pattern=rf"^[^\x00-\x1f\x7f]{{{least},{most}}}$",
        json_schema_extra={
            "allowed": f"{text} of {count} printable characters",
            "plural": plural,
        },
    )


def find(root: Schema, path: Sequence[int | str]) -> tuple[str, Schema | None]:
    """Follow the path of a problem through the schema; return the key and its schema.

    The names of union branches, which pydantic appends to a path, are left out. The schema of an
    unknown key is None.
    """
    key, schema = "", root
    for part in path:
        schema = _resolve(root, schema)
        if isinstance(part, int) and "items" in schema:
            key, schema = f"{key}[{part}]", schema["items"]
        elif part in schema.get("properties", {}):
            key, schema = f"{key}.{part}", schema["properties"][part]
        elif "properties" in schema:
            return f"{key}.{part}".removeprefix("."), None
        else:
            break
    return key.removeprefix("."), _resolve(root, schema)


def neighbours(root: Schema, path: Sequence[int | str]) -> list[str]:
    """Return the keys that the table holding the last part of `path` may have."""
    _, table = find(root, path[:-1])
    return list((table or {}).get("properties", {}))


def words(schema: Schema) -> str:
    """Describe the allowed values, such as ``a whole number from 0 to 65535``.

    Those of a type whose bounds do not say it come from `said`.
    """
    if "allowed" in schema:
        return str(schema["allowed"])
    # TOML has no null: a key that may be absent is left out.
    branches = [branch for branch in schema.get("anyOf", []) if branch.get("type") != "null"]
    values = [schema["const"]] if "const" in schema else schema.get("enum", [])
    return _or([words(branch) for branch in branches] or [shown(value) for value in values]) or (
        _kind(schema) + _range(schema)
    )


def shown(value: object) -> str:
    """Write a value as in the file, shortened if it is long, and no password of an address."""
    text = _LOGIN.sub("…@", json.dumps(value, ensure_ascii=False, default=str))
    text = {"NaN": "nan", "Infinity": "inf", "-Infinity": "-inf"}.get(text, text)
    return text if len(text) <= 60 else f"{text[:59]}…"


def _resolve(root: Schema, schema: Schema) -> Schema:
    """Follow a reference to one of the root's definitions; keep the keys beside it."""
    if "$ref" not in schema:
        return schema
    beside = {name: value for name, value in schema.items() if name != "$ref"}
    return {**root["$defs"][schema["$ref"].rpartition("/")[2]], **beside}


def _kind(schema: Schema) -> str:
    kinds = {
        "boolean": "true or false",
        "integer": "an even number" if schema.get("multipleOf") == 2 else "a whole number",
        "number": "a number",
        "string": _text(schema),
        "array": f"a list of {_plural(schema.get('items', {}))}",
        "object": _table(schema),
    }
    return kinds.get(schema.get("type", ""), "a table")


def _table(schema: Schema) -> str:
    values = schema.get("additionalProperties")
    return f"a table of names, each with {words(values)}" if isinstance(values, dict) else "a table"


def _text(schema: Schema) -> str:
    if "pattern" in schema:
        return f"a text like {schema['pattern']}"
    return "a text that is not empty" if schema.get("minLength") else "a text"


def _plural(items: Schema) -> str:
    """Say what a list is of: the `plural` that its items' type names, or names."""
    plain = {"string": "names", "integer": "numbers", "number": "numbers"}
    return str(items.get("plural") or plain.get(items.get("type", ""), "tables"))


def _range(schema: Schema) -> str:
    """Describe the bounds of a number or of a list's length, with a leading space."""
    if "maxItems" in schema:
        return f", {schema.get('minItems', 0)} to {schema['maxItems']} of them"
    if "minimum" in schema and "maximum" in schema:
        return f" from {_plain(schema['minimum'])} to {_plain(schema['maximum'])}"
    bounds = {
        "minimum": "at least",
        "exclusiveMinimum": "above",
        "maximum": "at most",
        "exclusiveMaximum": "below",
    }
    said = [f"{how} {_plain(schema[bound])}" for bound, how in bounds.items() if bound in schema]
    return f" {', '.join(said)}" if said else ""


def _plain(number: float) -> str:
    return str(number).removesuffix(".0")


def _or(choices: list[str]) -> str:
    *others, last = choices or [""]
    return f"{', '.join(others)} or {last}" if others else last
