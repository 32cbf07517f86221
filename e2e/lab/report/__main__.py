"""``python -m e2e.lab.report RUN.json [OUT.html]``: the page, beside the run unless told where.

The figures are computed anew from the run's readings before, over the time that they were of, so
that where a sum was mended the run need not be measured again. The file of the run stays as it is.

Exit status: 0, or 2 with one sentence when the run cannot be read or the page not be written.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from e2e.lab.report import write
from e2e.lab.report.load import RunFileError, load
from e2e.lab.summed import ColumnsError, anew


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.lab.report", description="Make a page of a run of the lab."
    )
    parser.add_argument("run", type=Path, metavar="RUN.json", help="what the lab has written")
    parser.add_argument("out", type=Path, metavar="OUT.html", nargs="?", help="the page")
    given = parser.parse_args(arguments)
    path: Path = given.run
    out: Path = given.out or path.with_suffix(".html")
    try:
        run = load(path)
        if out.resolve() == path.resolve():
            raise RunFileError(f"{out} is the run itself; name another file for the page.")
        write(anew(run), out)
    except RunFileError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        why = error.strerror or error
        print(f"{out} cannot be written: {why}; name another file.", file=sys.stderr)
        return 2
    except ColumnsError as error:
        print(f"{path}: {error}; name the JSON that the lab has written.", file=sys.stderr)
        return 2
    print(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
