"""``python -m e2e.lab.face FILE``: write the talking face for a person to look at."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from pathlib import Path

from e2e.lab.face.film import looks, write
from e2e.lab.face.voice import speak
from e2e.measure.errors import MeasureError


def main() -> int:
    parser = ArgumentParser(prog="python -m e2e.lab.face", description="Write the talking face.")
    parser.add_argument("file", type=Path, help="where to; a name that ends with .mp4 or .mkv")
    file: Path = parser.parse_args().file
    if file.suffix.lower() not in {".mp4", ".mkv"}:
        parser.error(f"{file.name} is no film's name; let it end with .mp4 or .mkv.")
    if not file.parent.is_dir():
        parser.error(f"{file.parent} is no folder; make it or name another.")
    try:
        voice = speak()
        write(file, voice, looks(voice))
    except (MeasureError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
