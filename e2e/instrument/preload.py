"""The part of the instrument that runs in the page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from wax.protocol.messages import SoundReport

_PARTS: Final = ("clock", "hooks", "video_probe", "counts", "commands", "main")
NAME: Final = "__waxLab"


def preload(name: str = NAME) -> str:
    """Return the script to run before any of the page's; two of different names share a page."""
    folder = Path(__file__).parent / "page"
    parts = [(folder / f"{part}.js").read_text(encoding="utf-8") for part in _PARTS]
    known = {"NAME": name, "SOUND_REPORT": list(SoundReport.model_fields)}
    constants = [f"const {one} = {json.dumps(value)};" for one, value in known.items()]
    return "\n".join(["(() => {", *constants, *parts, "})();"])


PRELOAD: Final = preload()
