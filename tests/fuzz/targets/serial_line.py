"""The serial line: reports as the server reads them, and every frame as the board does.

Whoever can write on the line can also send a hello, so random bytes may move the board; but only a
drive, move or axis frame may, which our own decoder finds in the same bytes, too.
"""

from __future__ import annotations

from typing import Final

from tests.firmware.core import Core, Kind, Settings, Verdict
from tests.fuzz.target import Target

from wax.config.robot import RobotSettings
from wax.driver.interface import Twist
from wax.robot.line.setpoints import Order
from wax.robot.serial.frames import (
    START,
    AxisBody,
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    ReportBody,
    StopBody,
    encode,
)
from wax.robot.serial.frames_dialect import SILENT_AFTER_S, FramesDialect
from wax.robot.serial.odometry import Odometry
from wax.robot.wheels import WheelMixer

_SESSION: Final = 0x1234
_BEGAN_S: Final = 100.0
_PIECE: Final = 7
"""A line delivers bytes in pieces that do not respect frames."""


def _pieces(data: bytes) -> list[bytes]:
    return [data[at : at + _PIECE] for at in range(0, len(data), _PIECE)]


def _hear_server(data: bytes) -> None:
    for moves_sideways in (False, True):
        _hear_dialect(data, moves_sideways=moves_sideways)


def _hear_dialect(data: bytes, *, moves_sideways: bool) -> None:
    """Let a board send anything: values stay plausible, and only a board that answers is driven.

    A robot that moves sideways is driven by moves, if its board can; any other never is.
    """
    decoder = Decoder(_SESSION)
    whole = Decoder(_SESSION).feed(data)
    assert whole == [frame for piece in _pieces(data) for frame in decoder.feed(piece)]
    settings = RobotSettings()
    dialect = FramesDialect(
        *(WheelMixer(settings), 200, ("pan",), Odometry(settings)), moves_sideways=moves_sideways
    )
    dialect.hello(_BEGAN_S)
    # `hello` chose a random session; with that, stored inputs would not be accepted again.
    dialect._session, dialect._decoder = _SESSION, Decoder(_SESSION)
    order = Order(Twist(0.5, 0.0), 1, axes=(("pan", 0.5),))
    now_s = _BEGAN_S
    for piece in _pieces(data):
        now_s += 0.01
        dialect.receive_data(piece, now_s)
        assert dialect.reading.moving in (None, True, False)
        assert 0 <= dialect.reading.bumpers <= 0xFF
        assert 0 <= (dialect.reading.battery_v or 0.0) < 66
        assert all(isinstance(value, float) for value in dialect.reading.extra.values())
        answers = dialect.answers(now_s)
        said, _ = dialect.data_to_send(order, now_s)
        for frame in _read(said, dialect):
            assert answers or isinstance(frame.body, HelloBody | StopBody), f"it said {frame}"
            wrong = DriveBody if moves_sideways else MoveBody
            assert not isinstance(frame.body, wrong), f"it said {frame}"
        can = dialect._report is not None and dialect._report.moves_sideways
        assert can or not (moves_sideways and dialect.answers(now_s)), "it drives what cannot"
    assert not dialect.answers(now_s + SILENT_AFTER_S)


def _read(said: bytes, dialect: FramesDialect) -> list[Frame]:
    return Decoder(dialect._session).feed(said)


def _hear_board(data: bytes) -> None:
    for kind in (Kind.SIDES, Kind.MECANUM):
        _hear_core(data, kind)


def _hear_core(data: bytes, kind: Kind) -> None:
    core, decoder = Core(Settings(kind=kind), 1000), Decoder()
    heard: list[Frame] = []
    now_ms = 1000
    for piece in _pieces(data):
        now_ms += 5
        found = core.hear(piece, now_ms)
        heard += decoder.feed(piece)
        for frame, verdict in found:
            if verdict is Verdict.TAKEN:
                assert _is_among(frame, heard), f"the board took {frame}, which nobody said"
        core.tick(now_ms)
        core.report(now_ms)
        moving = DriveBody if kind is Kind.SIDES else DriveBody | MoveBody
        drives = [frame for frame in heard if isinstance(frame.body, moving)]
        assert drives or not any(core.wheels_mmps), "the wheels turn without a drive"
        axes = [frame for frame in heard if isinstance(frame.body, AxisBody)]
        assert axes or not any(core.axes), "an axis moves without a word"
    core.tick(now_ms + 1100)
    assert not any(core.wheels_mmps), "the wheels turn after the longest time-to-live"


def _is_among(frame: Frame, heard: list[Frame]) -> bool:
    return frame in heard


def _hello(sequence: int = 1) -> bytes:
    return encode(Frame(HelloBody(_SESSION), sequence=sequence), _SESSION)


def _frame(body: DriveBody | MoveBody | AxisBody | StopBody, sequence: int, turn: int = 1) -> bytes:
    ttl_ms = 0 if isinstance(body, StopBody) else 200
    frame = Frame(body, sequence=sequence, turn=turn, ttl_ms=ttl_ms, time_ms=1010)
    return encode(frame, _SESSION)


def _report(sequence: int, flags: int = 0, **more: int) -> bytes:
    body = ReportBody(
        battery_mv=7400, bumpers=1, left_ticks=5, right_ticks=-5, flags=flags, sequence=sequence
    )
    return encode(Frame(body, sequence=sequence, time_ms=1000, **more), _SESSION)


_WORDS: Final = (
    START, START + b"\x00", START + b"\x20", START + b"\x21", b"\xa5", _hello(2),
    _frame(StopBody(), 9), _frame(DriveBody(100, 100), 10), _frame(AxisBody(3, 10_000), 11),
    _frame(MoveBody(100, -100, 500), 12),
)  # fmt: skip

SERIAL: Final = Target(
    name="serial",
    what="serial frames, in the server",
    hear=_hear_server,
    seeds=(
        _report(1),
        _report(1) + _report(2, flags=1) + _report(3, flags=3),
        _report(2, flags=4) + _report(3, flags=5) + _report(4, flags=1),
        _hello() + _report(2),
        START * 5 + _report(2, turn=9),
    ),
    words=_WORDS,
    max_bytes=400,
    steps=200_000,  # the most that lines of a few bytes cost
)

FIRMWARE: Final = Target(
    name="firmware",
    what="serial frames, in the firmware's core",
    hear=_hear_board,
    seeds=(
        _hello() + _frame(StopBody(), 2) + _frame(DriveBody(300, -300), 3),
        _hello() + _frame(DriveBody(100, 100), 2, turn=2) + _frame(DriveBody(1, 1), 3, turn=1),
        _hello() + _frame(AxisBody(0, -10_000), 2) + _frame(AxisBody(200, 1), 3),
        _hello() + _frame(StopBody(), 2) + _frame(MoveBody(300, -300, 32_767), 3),
        _frame(DriveBody(100, 100), 2),
        _report(1),
    ),
    words=_WORDS,
    max_bytes=400,
)
