"""The configuration of the server under proof: the host's own, with what the proof replaces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from wax.config.as_toml import as_toml, key_as_toml
from wax.errors import ConfigError
from wax.session.kept_state import KeptFile

if TYPE_CHECKING:
    from wax.config.settings import Settings

_TURN_S: Final = 86_400.0
"""No turn ends during the proof."""
_OBSERVED: Final = "wax.commands.proof.observed:ObservedRobot"


def check(settings: Settings) -> None:
    """Raise `ConfigError` if no stop can be measured, or if the robot may not be driven."""
    if settings.local.is_on:
        raise ConfigError(
            "somebody may sit in the robot, and the proof would drive it without their hand"
            " control; prove the stop of the empty robot with a configuration that has source ="
            ' "none" in [local]'
        )
    if settings.robot.driver == "simulated":
        raise ConfigError(
            "the robot is simulated, so there is nothing to prove;"
            " name the configuration of a real robot with --config FILE"
        )


def check_stop(settings: Settings) -> None:
    """Raise `ConfigError` if a Stop is in force, which outlasts the server."""
    kept = KeptFile(settings.server.state_dir)
    if kept.before.stop is not None:
        why = " ".join(str(one) for one in kept.problems()) or "somebody has pressed Stop"
        raise ConfigError(f"{why}; start wax and release the Stop on its page first")


def tapped(settings: Settings, port: str, state: str) -> str:
    """Return a configuration whose robot is the host's, on another serial port."""
    robot = _robot(settings)
    return _under_proof(settings, robot | {"serial": robot["serial"] | {"url": port}}, state)


def observed(settings: Settings, log: str, state: str) -> str:
    """Return a configuration whose driver is the host's, with a log of its calls."""
    table = {"robot": settings.robot.model_dump_json(), "log": log}
    robot = _robot(settings) | {"driver": _OBSERVED, "observed": table}
    return _under_proof(settings, robot, state)


def _under_proof(settings: Settings, robot: dict[str, Any], state: str) -> str:
    """Return a configuration for `robot`, with [drive] and [stop] unchanged.

    `state` is its state folder. It has no camera, since the real one may be in use, and therefore
    drives at slow speed; it has no ICE servers, and a UDP port of its own.
    """
    return write(
        {
            "server": {"state_dir": state},
            "records": {"enabled": False},
            "network": {"udp_port": 0},
            "video": {"source": "none"},
            "audio": {"source": "none"},
            "turns": settings.turns.model_dump() | {"turn_s": _TURN_S},
            "drive": settings.drive.model_dump(),
            "stop": settings.stop.model_dump(),
            "robot": robot,
        }
    )


def _robot(settings: Settings) -> dict[str, Any]:
    """Return our own keys of [robot], as they are written."""
    robot = settings.robot.model_dump(include=set(type(settings.robot).model_fields))
    table = robot["serial"]["bytes"]
    none = {key: "none" if value is None else value for key, value in table.items()}
    return robot | {"serial": robot["serial"] | {"bytes": none}}


def write(tree: dict[str, Any]) -> str:
    """Return the TOML of a tree of tables, lists, texts, numbers and truth values."""
    return "".join(f"{key_as_toml(name)} = {as_toml(value)}\n" for name, value in tree.items())
