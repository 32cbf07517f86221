"""Renders the manual of the configuration's tables from their models.

What it says of a key is the docstring below that key, and of a table its model's. A blank line
there begins a new line, and indented lines are kept as they are.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from typing import TYPE_CHECKING, Any, Final, TypeGuard, get_args

from pydantic import BaseModel

from wax.config import allowed
from wax.config.as_toml import as_toml
from wax.field_docs import field_docs

if TYPE_CHECKING:
    from collections.abc import Iterator

_WIDTH: Final = 100
_SHORT: Final = 60
"""A default in a list's table is told if it is no longer than this."""

_NO_BREAK: Final = "\N{NO-BREAK SPACE}"

Model = type[BaseModel]
Path = tuple[int | str, ...]


def whole(model: Model) -> str:
    """Return the manual of a whole file."""
    return "\n".join([*comment(_text_of(model)), "", *table(model, "")]).rstrip() + "\n"


def table(model: Model, name: str) -> list[str]:
    """Return the manual of the table `name` and of those in it; of all tables if it is empty."""
    heading = [f"[{name}]"] if name else []
    return [*heading, *_Manual(model, name).table(model, ())]


class _Manual:
    """The lines of one manual: each key of a table, and then each table in it."""

    def __init__(self, model: Model, name: str) -> None:
        self._model = model
        self._name = name
        self._schema = model.model_json_schema()

    def table(self, model: Model, path: Path) -> Iterator[str]:
        texts, tables = purposes(model), _tables(model)
        for key in model.model_fields:
            if key not in tables:
                yield from self._key(model, (*path, key), texts[key])
        for key, inner in tables.items():
            yield from comment(texts[key] or _text_of(inner))
            yield f"[{'.'.join((self._name, *map(str, path), key)).removeprefix('.')}]"
            yield from self.table(inner, (*path, key))

    def _key(self, model: Model, path: Path, text: str) -> Iterator[str]:
        key, schema = str(path[-1]), self._schema_of(path)
        items = next(iter(models_in(model.model_fields[key].annotation)), None)
        yield from comment(text or (_text_of(items) if items else ""))
        if items is None:
            yield from comment(self._each(path))
        else:
            top = f"Write a table [[{key}]] for each, below all other keys. "
            yield from comment(f"{'' if self._name or path[1:] else top}Keys of each:")
            yield from self._listed(items, (*path, 0))
        yield from comment(f"Allowed: {allowed.words(schema)}")
        default = schema.get("default")
        yield f"# {key} = …" if default is None else f"{key} = {as_toml(default)}"
        yield ""

    def _listed(self, model: Model, path: Path) -> Iterator[str]:
        """Return the keys of a list's tables, each with its purpose, allowed values and default."""
        fields, texts = model.model_fields, purposes(model)
        width = max(map(len, fields)) + 2
        as_elsewhere: dict[str, list[str]] = {}
        for key in sorted(fields, key=lambda key: not fields[key].is_required()):
            text, schema = texts[key], self._schema_of((*path, key))
            if (twin := self._twin(key, text)) is not None:
                as_elsewhere.setdefault(twin, []).append(key)
                continue
            said = f"{text} {self._each((*path, key))} Allowed: {allowed.words(schema)}."
            default = schema.get("default")
            if default not in (None, "", [], {}) and len(as_toml(default)) <= _SHORT:
                said += f" Default: {as_toml(default)}"
            yield from _filled(said, f"#   {key.ljust(width)}", f"#   {' ' * width}")
        for table, keys in as_elsewhere.items():
            yield from _filled(f"{', '.join(keys)}: as in [{table}].", "#   ", "#   ")

    def _each(self, path: Path) -> str:
        """Return what each item of a list may be, unless these are tables; or nothing."""
        is_list = self._schema_of(path).get("type") == "array"
        items = self._schema_of((*path, 0)) if is_list else {"type": "object"}
        return "" if items.get("type") == "object" else f"Each is {allowed.words(items)}."

    def _twin(self, key: str, text: str) -> str | None:
        """Return the table that has the same key for the same purpose."""
        for name, model in _tables(self._model).items():
            if purposes(model).get(key) == text:
                return f"{self._name}.{name}".removeprefix(".")
        return None

    def _schema_of(self, path: Path) -> allowed.Schema:
        return allowed.find(self._schema, path)[1] or {}


def purposes(model: Model) -> dict[str, str]:
    """Return the purpose of each key: the docstring below it, else its description."""
    written = field_docs(model)
    fields = model.model_fields.items()
    return {key: written.get(key, field.description or "") for key, field in fields}


def comment(text: str) -> list[str]:
    """Return a text as comments."""
    lines, paragraph = list[str](), list[str]()
    for line in [*text.splitlines(), ""]:
        if line and not line[0].isspace():
            paragraph.append(line)
            continue
        lines += _filled(" ".join(paragraph), "# ", "# ")
        lines += [f"# {line}"] if line else []
        paragraph.clear()
    return lines


def _filled(text: str, first: str, others: str) -> list[str]:
    """Wrap a text, but for no command between backticks."""
    text = re.sub("`[^`]*`", lambda found: found[0].replace(" ", _NO_BREAK), " ".join(text.split()))
    lines = textwrap.wrap(
        text,
        _WIDTH,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(_NO_BREAK, " ") for line in lines]


def _tables(model: Model) -> dict[str, Model]:
    """Return the keys of a model that are tables."""
    fields = model.model_fields.items()
    return {key: field.annotation for key, field in fields if _is_model(field.annotation)}


def models_in(annotation: Any) -> list[Model]:
    """Return the models of a field's type: its own, or those that a list is of."""
    return [one for one in (annotation, *get_args(annotation)) if _is_model(one)]


def _is_model(annotation: Any) -> TypeGuard[Model]:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _text_of(model: Model) -> str:
    return inspect.cleandoc(model.__doc__ or "")
