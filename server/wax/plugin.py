"""Find somebody else's class by the name that the configuration gives it."""

from __future__ import annotations

import importlib
from typing import Any

from wax.errors import ConfigError


def is_plugin_name(name: str) -> bool:
    """Tell ``package.module:Class`` from a path, an address or a name of ours."""
    module, colon, attribute = name.partition(":")
    return (
        bool(colon)
        and attribute.isidentifier()
        and all(p.isidentifier() for p in module.split("."))
    )


def load_class(name: str, key: str) -> type[Any]:
    """Import ``package.module:Class``; `key` is the configuration key, for the sentence.

    Raises `ConfigError`.
    """
    module_name, _, attribute = name.partition(":")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise ConfigError(f"{key}: {name}: cannot import {module_name}: {error}") from error
    found = getattr(module, attribute, None)
    if not isinstance(found, type):
        raise ConfigError(f"{key}: {name}: {module_name} has no class {attribute}")
    return found
