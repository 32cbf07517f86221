"""What may be configured for a rover by MAVLink."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from wax.robot.mavlink.codec import Codec
from wax.robot.mavlink.mapping import Sticks, Velocity
from wax.robot.mavlink.settings import FRAME_BYTES, SIGNATURE_BYTES, MavlinkSettings


@pytest.mark.parametrize(
    "table",
    [
        {},
        {"baud": 57_600},
        {"baud": 57_600, "signing_key": "key"},
        {"command_hz": 100.0},
        {"baud": 38_400, "mode": "manual", "command_hz": 100.0},
        {"baud": 57_600, "command_hz": 62.0},
        {"baud": 300, "url": "udpin:0.0.0.0:14550"},
    ],
)
def test_a_line_with_room_is_accepted(table: dict[str, Any]) -> None:
    """The defaults, a telemetry radio and any network line have room."""
    MavlinkSettings.model_validate(table)


@pytest.mark.parametrize(
    ("table", "baud", "command_hz"),
    [
        ({"baud": 57_600, "command_hz": 63.0}, 58_500, 62),
        ({"baud": 57_600, "command_hz": 62.0, "signing_key": "key"}, 69_086, 51),
        ({"baud": 9_600, "mode": "acro"}, 16_429, 29),
        ({"baud": 9_600, "command_hz": 20.0}, 18_572, None),
    ],
)
def test_a_line_that_set_points_would_fill_is_refused(
    table: dict[str, Any], baud: int, command_hz: int | None
) -> None:
    """It would delay a stop; the error suggests values, each of which is accepted."""
    with pytest.raises(ValidationError) as refused:
        MavlinkSettings.model_validate(table)
    sentence = str(refused.value)
    assert f"set baud to {baud} or more" in sentence
    MavlinkSettings.model_validate(table | {"baud": baud})
    assert ("or command_hz to" in sentence) == (command_hz is not None)
    if command_hz is not None:
        assert f"or command_hz to {command_hz}" in sentence
        MavlinkSettings.model_validate(table | {"command_hz": float(command_hz)})


@pytest.mark.parametrize(
    "table", [{"system": 255}, {"own_system": 1}, {"system": 7, "own_system": 7}]
)
def test_the_rover_and_we_have_two_numbers(table: dict[str, int]) -> None:
    """With one number its messages would count as ours; the error says what to set."""
    with pytest.raises(ValidationError) as refused:
        MavlinkSettings.model_validate(table)
    assert "set system to its SYSID_THISMAV and own_system to its SYSID_MYGCS" in str(refused.value)
    MavlinkSettings.model_validate({"system": 255, "own_system": 1})


@pytest.mark.parametrize(("key", "signature_bytes"), [(None, 0), (bytes(32), SIGNATURE_BYTES)])
def test_a_set_point_has_the_calculated_length(key: bytes | None, signature_bytes: int) -> None:
    """Encoded motion and standstill have it."""
    codec = Codec(255, 1, key, 1_800_000_000_000)
    for share in (0, 1):
        velocity = codec.velocity(Velocity(0.6 * share, -1.5 * share), 1e6)
        assert len(velocity) == FRAME_BYTES["guided"] + signature_bytes
        sticks = codec.sticks(Sticks(1000 * share, -1000 * share))
        assert len(sticks) == FRAME_BYTES["manual"] + signature_bytes
        assert FRAME_BYTES["acro"] == FRAME_BYTES["manual"]
