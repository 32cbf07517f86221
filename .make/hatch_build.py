"""Hatchling's build hook: the page goes into every wheel and source archive.

A source archive includes the built page, so installing from it needs no Node.
"""

from __future__ import annotations

import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent))  # hatchling loads this file, not its folder
import page


class PageHook(BuildHookInterface[Any]):
    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        """Require nothing if the page is already built, otherwise what building it needs."""
        if page.is_built():
            return []
        project = tomllib.loads((page.ROOT / "pyproject.toml").read_text(encoding="utf-8"))
        schema = [need for need in project["project"]["dependencies"] if "pydantic" in need]
        return schema + ([] if page.has_node() else project["dependency-groups"]["node"])

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the page, except for editable installs, where make or the developer builds it.

        Why it cannot be built is a sentence among what pip shows, not a traceback.
        """
        if version == "editable" or page.is_built():
            return
        with tempfile.TemporaryDirectory() as folder:
            try:
                if not page.has_node():
                    page.link_node(Path(folder))
                page.build(page.environment(Path(folder)))
            except page.PageError as error:
                sys.exit(f"wax: the page was not built: {error}")
