"""The eight errors, applied to stop and release, while the operator keeps holding the control.

Of stop it is wrong that one latches nothing, that what is none latches, or that a release which is
not its own ends it; one that comes late or twice may stop. Of release, that a wrong one ends the
stop. Of both, motion from the stop until somebody presses anew.
"""

from __future__ import annotations

import asyncio
import json
import time
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually
from e2e.measure.errors import MeasureError
from e2e.stop.harm import NO_STOPS, STOP, no_releases

if TYPE_CHECKING:
    from e2e.stop.harm import Channel

_TOO_LATE_S: Final = 2.2
"""A release sent after the stop is valid for two seconds."""
_BEATS_S: Final = 0.2


class LatchHarm:
    """Injects each error into one stop or one release; afterwards no stop is latched."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._operator = channel.operator
        self._stranger = channel.stranger
        self._newest = 0
        self._since_s: float | None = None

    async def stop(self, error: str) -> int:
        """Damage a stop, then release the one before it; count what is wrong."""
        operator, random = self._operator, self._channel.random
        wrong = 0
        self._since_s = None
        match error:
            case "repetition":
                await self._press()
                if random.random() < 0.5:
                    await self._free()
                    operator.state.send(STOP)
                else:
                    operator.state.send(STOP.encode())
            case "wrong order":
                operator.release(self._newest + 1)
                operator.state.send(STOP)
            case "loss":
                await operator.press_stop()  # as a page does beside the channel
            case "delay":
                await operator.press_stop()
                await self._free()
                operator.state.send(STOP)
            case "masquerade":
                self._stranger.state.send(STOP)  # everybody may, and only that
            case _:
                self._send_no_stop(error)
                wrong += await self._latched() is not None
                operator.state.send(STOP)
        number = await self._latched()
        if number is None:
            return wrong + 1
        if error == "masquerade":
            self._stranger.release(number)
        else:
            operator.release(number - 1)
        wrong += await self._latched() is None
        await self._free()
        return wrong + await self._moved()

    async def release(self, error: str) -> int:
        """Press Stop and damage its release; count what is wrong."""
        operator, random = self._operator, self._channel.random
        self._since_s = None
        before_ms = operator.server_ms()
        stop = await self._press()
        now_ms = operator.server_ms()
        right: dict[str, Any] = {"type": "release", "stop": stop, "sent_server_ms": now_ms}
        right["beat"] = operator.beat
        text = json.dumps(right)
        match error:
            case "corruption":
                for _ in range(3):
                    operator.state.send(self._channel.damaged(text))
            case "repetition" | "wrong order" | "loss":
                await self._send_at_the_next_stop(error, text)
            case "delay":
                if random.random() < 0.5:
                    await asyncio.sleep(_TOO_LATE_S)
                else:
                    right["sent_server_ms"] = before_ms - self._channel.some_ms(20, 9000)
                operator.say(**right)
            case "insertion":
                ahead = {"sent_server_ms": before_ms + random.uniform(1000, 5000)}
                for other in (ahead, *random.sample(no_releases(right), 2)):
                    operator.say(**right | other)
            case "masquerade":
                self._stranger.release(stop)
            case "wrong address" if random.random() < 0.5:
                operator.drive.send(random.choice((text, json.dumps(list(right.values())))))
            case _:
                operator.release(stop + random.choice((-1, 1, 2, 9)))
        wrong = int(await self._latched() is None)
        await self._free()
        return wrong + await self._moved()

    def _send_no_stop(self, error: str) -> None:
        operator, random = self._operator, self._channel.random
        match error:
            case "corruption":
                for _ in range(3):
                    operator.state.send(self._channel.damaged(STOP))
            case "insertion":
                operator.state.send(random.randbytes(20))
                for text in random.sample(NO_STOPS, 2):
                    operator.state.send(text)
            case _:
                operator.drive.send(random.choice((STOP, STOP.encode(), '["stop"]')))

    async def _send_at_the_next_stop(self, error: str, text: str) -> None:
        """Send a right release once more, or after somebody has pressed again, or found after all.

        What it was meant for ended by it, was pressed anew since then, or was ended by another.
        """
        if error == "repetition":
            self._operator.state.send(text)
        if error != "wrong order":
            await self._free()
        await self._press()
        self._operator.state.send(text)

    async def _press(self) -> int:
        """Press Stop correctly; return its number."""
        self._operator.state.send(STOP)
        stop = await self._latched()
        if stop is None:
            raise MeasureError("Stop was pressed, and none is latched")
        return stop

    async def _free(self) -> None:
        """Release correctly whatever is latched."""

        async def free() -> bool:
            stop = await self._latched()
            if stop is not None:
                self._operator.release(stop)
            return stop is None

        await eventually(free, "the stop is released", every_s=0.01)

    async def _latched(self) -> int | None:
        """Return which stop is latched, once everything sent before has arrived."""
        if not all(await asyncio.gather(self._operator.pongs(), self._stranger.pongs())):
            raise MeasureError("the server does not answer a peer")
        stop = (await self._channel.stage.server.status())["stop"]
        if stop is None:
            return None
        self._since_s = self._since_s or time.monotonic()
        self._newest = int(stop["number"])
        return self._newest

    async def _moved(self) -> int:
        """Count the frames that move although a stop has been latched.

        Frames already in flight to the board come before a stopping frame; it is also wrong if none
        stops within some periods.
        """
        assert self._since_s is not None
        record, end_s = self._channel.stage.record, time.monotonic() + _BEATS_S
        while True:
            record.read()
            found = record.stopping(self._since_s, time.monotonic())
            if found.told_ms is not None or time.monotonic() > end_s:
                return found.moved_again + (found.told_ms is None)
            await asyncio.sleep(0.005)
