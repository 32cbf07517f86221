"""The configuration with which WAX is started for a cell; it reads no file but the thesis's."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.delay.systems.served import PORT
from e2e.harness.toml import MANY_PLAYED_BY_ONE, MEDIA, PICTURE, merged
from e2e.peers.sizes import VGA

if TYPE_CHECKING:
    from e2e.delay.cell import Cell

THESIS: Final = Path(__file__).parents[3] / "config" / "thesis.toml"

TURN_S: Final = 3600.0
"""No turn ends within a cell, because turns are not measured here."""

DRIVES_HZ: Final = 20.0
"""Set-points a second where a cell drives: the rate that the goal of the modem line names."""


def settings(cell: Cell) -> dict[str, Any]:
    """Return the tree of keys in which a system of WAX's differs from the shipped configuration."""
    tree: dict[str, Any] = {
        "server": {"host": "0.0.0.0", "port": PORT},
        **MEDIA,
        "turns": {"turn_s": TURN_S},
    }
    if cell.given is not VGA:
        size = cell.given
        tree["video"] = {"source": size.source, "width": size.width, "height": size.height}
    if cell.player != "auto":
        tree["sync"] = {role: {"player": cell.player} for role in ("operator", "observer")}
    for_all = merged(PICTURE, MANY_PLAYED_BY_ONE, tree)
    match cell.system:
        case "operator":
            asks = merged(for_all, {"turns": {"join": "ask"}})
            return merged(asks, {"drive": {"command_rate_hz": DRIVES_HZ}}) if cell.drives else asks
        case "video-first":
            both = {"operator": {"policy": "video-first"}, "observer": {"policy": "video-first"}}
            return merged(for_all, {"sync": both})
        case "thesis":
            thesis = tomllib.loads(THESIS.read_text(encoding="utf-8"))
            tree = merged(for_all, thesis, tree)
            if cell.audio_mu_ms is None:
                return tree
            return merged(tree, {"thesis": {"audio_mu_ms": cell.audio_mu_ms}})
    return for_all
