"""``python -m e2e.lab.instrument.tether PROGRAM …``: runs it until standard input is closed.

For what must not outlive who started it: however that one ends, the kernel closes the pipe. Exit
status: the program's.
"""

from __future__ import annotations

import os
import subprocess
import sys
from threading import Thread
from typing import Final

_ASK_FOR_S: Final = 10.0


def main() -> int:
    program = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL)
    Thread(target=_end_with_input, args=[program], daemon=True).start()
    return program.wait()


def _end_with_input(program: subprocess.Popen[bytes]) -> None:
    while os.read(0, 4096):
        pass
    program.terminate()
    try:
        program.wait(_ASK_FOR_S)
    except subprocess.TimeoutExpired:
        program.kill()


if __name__ == "__main__":
    sys.exit(main())
