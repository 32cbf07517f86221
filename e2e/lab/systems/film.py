"""The film of a talking head that all systems show, made once on a machine."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Final

from e2e.lab.talking_head import film_file

FOLDER: Final = Path(__file__).parents[3] / ".cache" / "lab"


async def film() -> Path:
    """Return its path; raises `NotRunError` where it cannot be made."""
    return await asyncio.to_thread(film_file, FOLDER)
