"""The talking face that all systems show, made once on a machine."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Final

from e2e.lab.face import face_file

FOLDER: Final = Path(__file__).parents[3] / ".cache" / "lab"


async def film() -> Path:
    """Return its path; raises `NotRunError` where it cannot be made."""
    return await asyncio.to_thread(face_file, FOLDER)
