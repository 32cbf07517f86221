"""Validates and describes drivers' own tables `[robot.TABLE]`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from wax.config import manual, problems
from wax.config.driver_settings import DriverSettings
from wax.errors import ConfigError, PluginError
from wax.plugin import DRIVERS, load_class, offers

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

_KEY: Final = "robot.driver"
_CONTRACT: Final = "wax/config/driver_settings.py"


def check_here(robot: dict[str, Any], *, ours: Collection[str]) -> list[str]:
    """Return a sentence for each wrong key of the drivers' tables in `[robot]`, as written.

    `ours` are the keys of `[robot]` itself. Tables of WAX's own drivers are always allowed, another
    driver's only if it is the configured one, since only its class can validate it. Loads the
    classes; a class that cannot be loaded is no mistake in the table.
    """
    lines = []
    for name, table in tables(robot, ours).items():
        try:
            model = _model(name, _driver(robot), ours)
        except PluginError:
            continue
        except ConfigError as error:
            lines.append(str(error))
        else:
            lines += _check(model, name, table)
    return list(dict.fromkeys(lines))


def tables(robot: dict[str, Any], ours: Collection[str]) -> dict[str, dict[str, Any]]:
    """Return the tables in `[robot]` that are not its own."""
    return {
        name: table for name, table in robot.items() if name not in ours and isinstance(table, dict)
    }


def is_ours(robot: dict[str, Any]) -> bool:
    """Whether the driver comes with WAX, so that its class may be loaded anywhere."""
    return _driver(robot) in {offer.name for offer in offers(DRIVERS) if offer.is_ours}


def model_of(driver: type[Any], name: str, ours: Collection[str]) -> type[DriverSettings] | None:
    """Return the driver's `Settings`, None if it has none; raises `ConfigError` for a wrong one."""
    model = getattr(driver, "Settings", None)
    if model is None:
        return None
    if not (isinstance(model, type) and issubclass(model, DriverSettings)):
        raise ConfigError(f"{_KEY}: {name}: its Settings are no DriverSettings; see {_CONTRACT}.")
    table = getattr(model, "TABLE", None)
    if not isinstance(table, str) or not table.isidentifier() or table in ours:
        raise ConfigError(
            f"{_KEY}: {name}: its Settings have the TABLE {table!r}; give them a name that is not a"
            f" key of [robot]; see {_CONTRACT}."
        )
    return model


def describe(names: Sequence[str], *, ours: Collection[str]) -> list[str]:
    """Return the manual's lines for these drivers' tables, or for all that are installed.

    Raises `ConfigError` for an unknown driver; among all, one that cannot be loaded is a line.
    """
    lines = []
    for name in names or dict.fromkeys(offer.name for offer in offers(DRIVERS)):
        try:
            model = model_of(load_class(name, DRIVERS, _KEY), name, ours)
        except ConfigError as error:
            if names:
                raise
            lines += [*manual.comment(str(error)), ""]
            continue
        if model is None:
            own = f"[robot.{name}] is in the manual" if name in ours else "has no keys of its own"
            lines += [f"# {name}: {own}.", ""]
        else:
            lines += [f"# {name}", *manual.table(model, f"robot.{model.TABLE}")]
    return lines


def _driver(robot: dict[str, Any]) -> str:
    return str(robot.get("driver", "simulated"))


def _model(table: str, driver: str, ours: Collection[str]) -> type[DriverSettings]:
    """Find the driver's model for a table; raises `ConfigError`."""
    for offer in offers(DRIVERS):
        if offer.is_ours and offer.name == table:
            model = model_of(load_class(table, DRIVERS, _KEY), table, ours)
            if model is not None:
                return model
    model = model_of(load_class(driver, DRIVERS, _KEY), driver, ours)
    if model is not None and table == model.TABLE:
        return model
    if any(offer.name == table for offer in offers(DRIVERS)):
        raise ConfigError(
            f'robot.{table}: is for driver = "{table}", but driver is "{driver}"; leave one of them'
            " out"
        )
    raise ConfigError(
        problems.unknown(f"robot.{table}", [*ours, *([model.TABLE] if model else [])])
    )


def _check(model: type[DriverSettings], name: str, table: dict[str, Any]) -> list[str]:
    try:
        model.model_validate(table)
    except ValidationError as error:
        return problems.lines(error, model.model_json_schema(), f"robot.{name}")
    except Exception as error:  # a plug-in's validator may raise anything
        return [f"robot.{name}: checking it failed: {error!r}"]
    return []
