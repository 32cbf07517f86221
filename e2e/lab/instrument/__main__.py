"""``python -m e2e.lab.instrument``: the instrument's own error as JSON on standard output.

Exit status: 0 when it is within what is promised, 1 when it is not, 2 when it cannot be measured.
"""

from __future__ import annotations

import asyncio
import json
import sys

from e2e.lab.errors import LabError
from e2e.lab.instrument.error import own_error


def main() -> int:
    try:
        found = asyncio.run(own_error())
    except LabError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    print(json.dumps(found, indent=1))
    return 0 if found["ok"] else 1


if __name__ == "__main__":
    sys.exit(main())
