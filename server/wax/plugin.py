"""Load a plug-in class by its name in the configuration, and build it."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from wax.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Iterable


def is_plugin_name(name: str) -> bool:
    """Whether `name` is ``package.module:Class``, not a path, an address or a built-in name."""
    module, colon, attribute = name.partition(":")
    return (
        bool(colon)
        and attribute.isidentifier()
        and all(p.isidentifier() for p in module.split("."))
    )


def make_plugin(
    name: str, key: str, settings: object, clock: object, *, needs: Iterable[str], contract: str
) -> Any:
    """Build ``package.module:Class`` as ``Class(settings, clock)``.

    `needs` names the methods that it must have, `contract` the file that explains them, and `key`
    the configuration key for the message. Raises `ConfigError`, whatever the plug-in raises.
    """
    found = _load_class(name, key)
    for method in needs:
        if not callable(getattr(found, method, None)):
            raise ConfigError(f"{key}: {name} has no method {method}; see {contract}.")
    try:
        return found(settings, clock)
    except Exception as error:
        raise ConfigError(f"{key}: {name}(settings, clock) failed: {error!r}") from error


def _load_class(name: str, key: str) -> type[Any]:
    module_name, _, attribute = name.partition(":")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise ConfigError(f"{key}: {name}: cannot import {module_name}: {error}") from error
    except Exception as error:
        raise ConfigError(f"{key}: {name}: importing {module_name} failed: {error!r}") from error
    found = getattr(module, attribute, None)
    if not isinstance(found, type):
        raise ConfigError(f"{key}: {name}: {module_name} has no class {attribute}")
    return found
