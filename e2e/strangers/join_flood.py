"""Two hundred offers a second that nobody follows up, while somebody drives."""

from __future__ import annotations

import asyncio
import json
import statistics
import time
from typing import TYPE_CHECKING, Any, Final

from e2e.harness import toml
from e2e.load.process import ProcessMeter
from e2e.measure.errors import MeasureError
from e2e.measure.row import judged, summed
from e2e.measure.summary import summarize
from e2e.stop.operator import RawOperator
from e2e.stop.stage import Load, staged
from e2e.strangers.command_times import CommandTimes
from e2e.strangers.hostile import begin
from e2e.strangers.strangers import strangers

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.strangers.strangers import Strangers

MORE_MS: Final = 10.0
FEWER_FPS: Final = 0.05
MORE_MIB: Final = 100.0
BACK_S: Final = 30.0
BACK: Final = 0.1
"""What the allocator keeps still counts as back, as a share of what there was."""
GUEST_S: Final = 1.0
FLOODER_CPU: Final = 0.2
_HOST_EVERY_S: Final = 2.0
_SETTLE_S: Final = 3.0

LOAD: Final = Load(
    "640×480 at 30 fps",
    {"video": {"source": "testcard"}, "audio": {"source": "none"}},
    0,
)


async def join_flood(n: int, addresses: int, *, load: Load = LOAD) -> list[Row]:
    """Flood for `n` seconds, after as long without; memory gets up to 30 s to come back."""
    async with (
        staged(toml.as_shipped(), load=load) as stage,
        RawOperator(stage.server, sees=True) as operator,
        strangers("joiner", stage.server.url, stage.server.state_folder) as joiner,
    ):
        meter = ProcessMeter(stage.server.pid)
        await operator.join()
        await stage.drive(operator)
        for who in ("host", "guest"):  # what is loaded at the first peer counts for no flood
            await _join(joiner, who)
        times = CommandTimes(stage, operator)
        changing = asyncio.create_task(times.run())
        try:
            await asyncio.sleep(_SETTLE_S)
            calm = await _window(operator, n)
            before_mib = meter.rss_mib()
            async with strangers("attacks", stage.server.port) as flood:
                await begin(flood, f"offers-{addresses}", n)
                memory = Peak(meter)
                watching = asyncio.create_task(memory.watch())
                hosts = asyncio.create_task(_hosts(joiner, n))
                flooded = await _window(operator, n)
                host_s = await hosts
                guest = await _join(joiner, "guest")
                account = await flood.account()
                account["sent_hz"] = account["did"]["offers"] / n
            back_mib, back_s = await _back(meter, before_mib)
            watching.cancel()
            if changing.done():
                await changing
        finally:
            changing.cancel()
        calm_ms = times.between(calm["since_s"], calm["until_s"])
        flooded_ms = times.between(flooded["since_s"], flooded["until_s"])
        stops = sum(flooded["since_s"] <= at_s <= flooded["until_s"] for at_s in times.stands_s)
    return _rows(
        f"join-flood-{addresses}",
        addresses,
        calm=calm_ms,
        flooded=flooded_ms,
        fps=(calm["fps"], flooded["fps"]),
        mib=(before_mib, memory.mib, back_mib),
        back_s=back_s,
        host_s=host_s,
        guest=guest,
        account=account | {"stops": stops},
    )


def _rows(
    key: str,
    addresses: int,
    *,
    calm: list[float | None],
    flooded: list[float | None],
    fps: tuple[float, float],
    mib: tuple[float, float, float],
    back_s: float,
    host_s: list[float | None],
    guest: dict[str, Any],
    account: dict[str, Any],
) -> list[Row]:
    came = [ms for ms in calm if ms is not None]
    if not came or account["cpu_share"] > FLOODER_CPU:
        raise MeasureError(f"{key}: no fair run: {len(came)} commands before, {account}")
    calm_p99_ms = summarize(came).p99
    where = "one address" if addresses == 1 else f"{addresses} addresses"
    before_mib, peak_mib, back_mib = mib
    return [
        summed(
            key,
            f"{account['sent_hz']:.0f} offers a second from {where}: command → frame"
            f" (before: p99 {calm_p99_ms:.0f} ms)",
            "ms",
            flooded,
            calm_p99_ms + MORE_MS,
            judged="p99",
            wrong=account["stops"],
            account=account,
        ),
        judged(
            f"{key}: fps",
            "… pictures a second fewer for the operator",
            "%",
            {"max": 100 * (1 - fps[1] / fps[0])},
            100 * FEWER_FPS,
            n=1,
            column="max",
            detail={"before_fps": fps[0], "flooded_fps": fps[1]},
        ),
        judged(
            f"{key}: memory",
            "… more memory meanwhile",
            "MiB",
            {"max": peak_mib - before_mib},
            MORE_MIB,
            n=1,
            column="max",
        ),
        judged(
            f"{key}: memory after",
            f"… and at most {BACK_S:.0f} s later",
            "MiB",
            {"max": back_mib - before_mib},
            BACK * before_mib,
            n=1,
            column="max",
            detail={"back_s": back_s},
        ),
        summed(f"{key}: host", "… the host gets in meanwhile", "s", host_s, 5.0),
        summed(
            f"{key}: guest",
            "… a guest gets in afterwards",
            "s",
            [guest["took_s"]],
            GUEST_S,
            problem=guest.get("problem"),
        ),
    ]


class Peak:
    """The most memory that a process has had while `watch` runs."""

    def __init__(self, meter: ProcessMeter) -> None:
        self._meter = meter
        self.mib = meter.rss_mib()

    async def watch(self) -> None:
        while True:
            self.mib = max(self.mib, self._meter.rss_mib())
            await asyncio.sleep(0.5)


async def _window(operator: RawOperator, n: int) -> dict[str, float]:
    since_s, frames = time.monotonic(), operator.media.counts("video").frames
    await asyncio.sleep(n)
    until_s = time.monotonic()
    fps = (operator.media.counts("video").frames - frames) / (until_s - since_s)
    return {"since_s": since_s, "until_s": until_s, "fps": fps}


async def _hosts(joiner: Strangers, n: int) -> list[float | None]:
    """Let the host come and go until the flood is nearly over; return how long each took."""
    ends_s, found = time.monotonic() + n - 1.0, list[float | None]()
    while not found or time.monotonic() < ends_s:
        found.append((await _join(joiner, "host"))["took_s"])
        await asyncio.sleep(_HOST_EVERY_S)
    return found


async def _join(joiner: Strangers, who: str) -> dict[str, Any]:
    await joiner.say(who)
    found: dict[str, Any] = json.loads(await joiner.line())
    return found


async def _back(meter: ProcessMeter, before_mib: float) -> tuple[float, float]:
    """Wait until memory is back, at most 30 s; return what it is, and after how long."""
    start_s = time.monotonic()
    while True:
        mib = statistics.median([meter.rss_mib() for _ in range(3)])
        passed_s = time.monotonic() - start_s
        if mib <= before_mib * (1 + BACK) or passed_s > BACK_S:
            return mib, passed_s
        await asyncio.sleep(0.5)
