"""``python -m e2e.lab.client2004``: thesis beside model. With a trace: what it would have heard.

Exit status: 0, or 2 with one sentence when the trace cannot be replayed.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from e2e.lab.client2004.errors import TraceError
from e2e.lab.client2004.path import RecordedPath
from e2e.lab.client2004.scenes import SCENES
from e2e.lab.client2004.table import MU_LENGTHS_MS, hear, table, words


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m e2e.lab.client2004", description=__doc__)
    parser.add_argument(
        "--trace",
        type=Path,
        help='a file of "sent_ms arrived_ms" lines, one way, to hear through the Linux client',
    )
    trace: Path | None = parser.parse_args().trace
    if trace is None:
        print(table())
        return 0
    try:
        path = RecordedPath.from_lines(trace.read_text("utf-8").splitlines())
    except UnicodeDecodeError:
        return _refuse(trace, 'This is no text; a trace is lines of "sent_ms arrived_ms".')
    except OSError as error:
        return _refuse(trace, f"It cannot be read: {error.strerror}.")
    except TraceError as error:
        return _refuse(trace, str(error))
    for mu_ms in MU_LENGTHS_MS:
        print(f"{mu_ms} ms: {words(hear(SCENES[0], mu_ms, path=path))}")
    return 0


def _refuse(trace: Path, sentence: str) -> int:
    print(f"{trace}: {sentence}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
