"""Who may press Stop, on the data channel or by HTTP; the latch decides who may release it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.errors import ForbiddenError

if TYPE_CHECKING:
    from wax.config.settings import StopSettings
    from wax.control.loop import ControlLoop
    from wax.control.stop_latch import Releaser
    from wax.control.turns import Turns
    from wax.session.record_keeper import RecordKeeper
    from wax.session.viewer import Viewer

ONLY_THE_OPERATOR_STOPS: Final = "Only the operator or the host can stop this robot."


class StopAuthority:
    """Checks requests to the stop latch; `is_host` means a page on the server's own machine."""

    def __init__(
        self,
        *,
        settings: StopSettings,
        turns: Turns,
        control: ControlLoop,
        keeper: RecordKeeper,
    ) -> None:
        self._settings = settings
        self._keeper = keeper
        self._turns = turns
        self._control = control

    def press(self, viewer: Viewer | None, *, is_host: bool) -> int:
        """Latch the stop before anything else; returns its number. Raises `ForbiddenError`."""
        drives = viewer is not None and viewer.number == self._turns.operator
        if not (drives or is_host or self._settings.by == "everybody"):
            raise ForbiddenError(ONLY_THE_OPERATOR_STOPS)
        name = viewer.name if viewer is not None else "the host" if is_host else "somebody"
        number = self._control.press_stop(name)
        self._keeper.stop_pressed(viewer, name, number)
        return number

    def release(
        self, viewer: Viewer | None, stop: int, sent_s: float | None, *, is_host: bool
    ) -> None:
        """Release the stop with this number; raises `ForbiddenError` with the reason."""
        by: Releaser = "host" if is_host else None if viewer is None else viewer.number
        refusal = self._control.release_stop(by, stop, sent_s)
        if refusal is not None:
            raise ForbiddenError(refusal.value)
        self._keeper.stop_released("the host" if viewer is None else viewer.name)
