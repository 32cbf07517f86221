"""Finds a plug-in class by its name in the configuration, loads it, and builds it.

A name is ``package.module:Class``, or that of an installed package's entry point in one of the
groups below. WAX's own drivers and sources are offered in the same way.
"""

from __future__ import annotations

import importlib
import re
import sys
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING, Any, Final

from wax.errors import ConfigError, PluginError

if TYPE_CHECKING:
    from collections.abc import Iterable

DRIVERS: Final = "wax.drivers"
CAMERAS: Final = "wax.cameras"
MICROPHONES: Final = "wax.microphones"

_OURS: Final = "wax-teleop"
_KEYS: Final = {
    DRIVERS: "[robot] driver",
    CAMERAS: "[video] source",
    MICROPHONES: "[audio] source",
}
_MOVED: Final = {"wax.robot.driver": "wax.driver.interface", "wax.media": "wax.capture.source"}
"""What plug-ins for 0.1.0 import, each with the module that has its names now."""
_OF_EXTRA: Final = re.compile(r"""([\w.-]+)[^;]*;\s*extra\s*==\s*["']([\w.-]+)["']\s*""")
"""A requirement of an extra that applies on every system."""


@dataclass(frozen=True, slots=True)
class PluginOffer:
    """A class, as ``module:Class``, that an installed package offers under a name.

    `extra` is the package's extra of the same name, which installs the libraries that it needs.
    """

    name: str
    value: str
    package: str
    version: str
    extra: str | None = None

    @property
    def is_ours(self) -> bool:
        """Whether it comes with WAX."""
        return self.package == _OURS

    @property
    def origin(self) -> str:
        """Where it comes from, for people."""
        return "comes with WAX" if self.is_ours else f"of {self.package} {self.version}"

    @property
    def lacks(self) -> list[str]:
        """The packages of its extra that are not installed."""
        needs = [_OF_EXTRA.fullmatch(need) for need in metadata.requires(self.package) or ()]
        return [
            need[1]
            for need in needs
            if need and need[2] == self.extra and not _is_installed(need[1])
        ]

    @property
    def install(self) -> str:
        """The command that installs all it needs."""
        return f'pip install "{self.package}{f"[{self.extra}]" if self.extra else ""}"'


def offers(group: str) -> list[PluginOffer]:
    """Return the offers of the installed packages, ours first, sorted by name."""
    return list(_offers(group, tuple(sys.path)))


@cache
def _offers(group: str, _path: tuple[str, ...]) -> list[PluginOffer]:
    """Read every package's metadata on the path, which takes longer than a configuration."""
    found = {_offer(point) for point in metadata.entry_points(group=group)}
    return sorted(found, key=lambda offer: (not offer.is_ours, offer.name, offer.package))


def list_plugins() -> list[str]:
    """Return lines to print, one for each driver, camera and microphone on offer."""
    lines = ["Drivers and sources of installed packages:"]
    for group, key in _KEYS.items():
        for offer in offers(group):
            lacks = f"; to have it: {offer.install}" if offer.lacks else ""
            lines.append(f'  {key} = "{offer.name}"   # {offer.origin}{lacks}')
    return lines


def find_offer(name: str, group: str, key: str) -> PluginOffer | None:
    """Return the offer of this name, None if there is none; ours takes precedence.

    Raises `ConfigError` if two packages offer it. `key` is the configuration key for the message.
    """
    found = [offer for offer in offers(group) if offer.name == name]
    if len(found) > 1 and not found[0].is_ours:
        both = " and ".join(f"{offer.package} as {offer.value!r}" for offer in found)
        raise ConfigError(f"{key}: {name} is offered by {both}; write which of them you mean.")
    return found[0] if found else None


def is_plugin_name(name: str) -> bool:
    """Whether `name` is ``package.module:Class``, not a path, an address or a built-in name."""
    module, colon, attribute = name.partition(":")
    return (
        bool(colon)
        and attribute.isidentifier()
        and all(p.isidentifier() for p in module.split("."))
    )


def is_plugin(name: str, group: str, key: str) -> bool:
    """Whether `name` is either kind of name; raises `ConfigError` as `find_offer` does."""
    return is_plugin_name(name) or find_offer(name, group, key) is not None


def load_class(name: str, group: str | None, key: str) -> type[Any]:
    """Load a class; raises `ConfigError`, or `PluginError` if its module raises anything.

    Without a `group`, only ``package.module:Class`` is a name.
    """
    offer = None if group is None or is_plugin_name(name) else find_offer(name, group, key)
    if offer is None and not is_plugin_name(name):
        raise ConfigError(f"{key}: got {name!r}; possible are {_possible(group)}")
    module_name, _, attribute = (offer.value if offer else name).partition(":")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise ConfigError(_missing(f"{key}: {name}", module_name, offer, error)) from error
    except Exception as error:
        raise PluginError(f"{key}: {name}: importing {module_name} failed: {error!r}") from error
    found = getattr(module, attribute, None)
    if not isinstance(found, type):
        raise ConfigError(f"{key}: {name}: {module_name} has no class {attribute}")
    return found


def make_plugin(
    name: str,
    key: str,
    settings: object,
    clock: object,
    *,
    needs: Iterable[str],
    contract: str,
    group: str | None = None,
) -> Any:
    """Build the named class as ``Class(settings, clock)``.

    `needs` are the methods that it must have, `contract` is the file that explains them, `key` the
    configuration key for the message, and `group` its entry point group, if any. Raises
    `ConfigError`, whatever the plug-in raises.
    """
    found = load_class(name, group, key)
    for method in needs:
        if not callable(getattr(found, method, None)):
            raise ConfigError(f"{key}: {name} has no method {method}; see {contract}.")
    try:
        return found(settings, clock)
    except ConfigError:
        raise
    except ImportError as error:
        offer = None if group is None else find_offer(name, group, key)
        raise ConfigError(_missing(f"{key}: {name}", name, offer, error)) from error
    except Exception as error:
        raise PluginError(f"{key}: {name}(settings, clock) failed: {error!r}") from error


def _offer(point: metadata.EntryPoint) -> PluginOffer:
    package = point.dist
    if package is None:
        return PluginOffer(point.name, point.value, "an unknown package", "", None)
    extras = package.metadata.get_all("Provides-Extra") or []
    return PluginOffer(
        point.name,
        f"{point.module}:{point.attr}",
        package.name,
        package.version,
        extra=point.name if point.name in extras else None,
    )


def _is_installed(package: str) -> bool:
    try:
        metadata.distribution(package)
    except metadata.PackageNotFoundError:
        return False
    return True


def _missing(what: str, module: str, offer: PluginOffer | None, error: ImportError) -> str:
    if moved := _MOVED.get(error.name or ""):
        return f"{what} imports {error.name}, which is gone: its names are in {moved} now"
    if offer is not None and offer.extra and isinstance(error, ModuleNotFoundError):
        return f"{what} needs {error.name or 'more'}, which is not installed: {offer.install}"
    return f"{what}: cannot import {module}: {error}"


def _possible(group: str | None) -> str:
    names = [] if group is None else [repr(name) for name in _names(group)]
    if group is not None and not names:
        return "none, because this installation of WAX is older than its files; install it anew"
    own = "your own class as 'package.module:Class'"
    return f"{', '.join(names)}, or {own}" if names else own


def _names(group: str) -> list[str]:
    return list(dict.fromkeys(offer.name for offer in offers(group)))
