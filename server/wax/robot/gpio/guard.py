"""Switches the motors' pins off when the driver's process has died.

A pin has no watchdog: it keeps its last level after the process that drove it has died, even if
that level runs a motor. So the driver starts this program beforehand, as
``python -m wax.robot.gpio.guard PIN…``, with a pipe for its input. While the pipe is open the guard
holds no pin. If the pipe ends without the line ``bye``, the driver has died, and the guard opens
the pins and switches them off.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Final

from wax.machine import python_module
from wax.machine.priority import as_others, raise_priority

if TYPE_CHECKING:
    from collections.abc import Sequence

BYE: Final = b"bye\n"
TRY_FOR_S: Final = 2.0
TRY_EVERY_S: Final = 0.005
END_S: Final = 0.2


class Guard:
    """The driver's handle of the guard program."""

    def __init__(self, pins: Sequence[int]) -> None:
        with as_others():
            self._process = subprocess.Popen(
                [*python_module.command("wax.robot.gpio.guard"), *map(str, pins)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,  # the driver's own output is the pipe to the server
                env=python_module.environment(),
                # A signal to the driver's process group must not end its guard.
                start_new_session=True,
            )

    def dismiss(self) -> None:
        """End the guard; the pins are already off."""
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.write(BYE)
            self._process.stdin.close()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def clear(pins: Sequence[int]) -> list[int]:
    """Open the pins as soon as they are free and switch them off; return those switched off."""
    import gpiozero  # noqa: PLC0415 - loaded beforehand by `main`

    ends_s = time.monotonic() + TRY_FOR_S
    cleared: dict[int, object] = {}
    while len(cleared) < len(pins) and time.monotonic() < ends_s:
        for pin in pins:
            if pin not in cleared:
                with contextlib.suppress(Exception):  # the kernel has not freed the pin yet
                    cleared[pin] = gpiozero.DigitalOutputDevice(pin, initial_value=False)
        if len(cleared) < len(pins):
            time.sleep(TRY_EVERY_S)
    return list(cleared)


def main() -> None:
    """Wait for the end of the driver."""
    import gpiozero  # noqa: PLC0415

    gpiozero.Device.ensure_pin_factory()  # so that nothing needs loading later
    raise_priority()
    pins = [int(pin) for pin in sys.argv[1:]]
    if sys.stdin.buffer.read() == BYE:
        return
    cleared = clear(pins)
    print(f"the robot's driver has died; pins off: {cleared}", file=sys.stderr)  # noqa: T201


if __name__ == "__main__":
    main()
