"""What guests read of a fault."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from tests.session.room_states import line, room

from wax.control import reasons
from wax.protocol import messages, room_change
from wax.sentence import CATALOGUE, Sentence, says
from wax.session.diagnosis import for_guests

PORT = "/dev/ttyACM0"
LOST = Sentence("port.lost", {"port": PORT, "why": "unplugged", "seconds": 1})
FILE = Sentence("file.missing", {"name": "/home/ada/film.mp4"})
HARDWARE = sorted(
    code
    for code in CATALOGUE
    if re.match(r"robot|ros2|gpio|mavlink|port|p?i?camera|microphone|file|media|speaker|says", code)
    and code != "camera.named"
)
RULES = [one.value for rules in (reasons.Refusal, reasons.Hold, reasons.Limit) for one in rules]


def _robot(problem: Sentence | None) -> messages.RobotStatus:
    return messages.RobotStatus(connected=False, problem=problem)


def _failing(**more: Any) -> messages.RoomState:
    source = messages.SourceStatus(problem=FILE)
    named = Sentence("camera.named", {"name": "Door", "problem": FILE})
    parts = {
        "robot": _robot(LOST),
        "video": messages.ViewStatus(problem=FILE, undated=FILE),
        "audio": source,
        "voice": messages.VoiceInfo(problem=FILE),
        "cameras": [messages.SourceStatus(problem=named), messages.SourceStatus()],
        "tape": messages.Tape(
            running=False, why=Sentence("tape.stands", {"why": Sentence("tape.disk_full")})
        ),
    }
    return room(**parts | more)


def test_a_guest_reads_what_a_fault_means_and_no_details() -> None:
    """Each fault has a plain sentence of its own, without path, port or address."""
    told = json.loads(for_guests(_failing()).model_dump_json())
    assert told["robot"]["problem"] == {"code": "robot.trouble"}
    assert told["video"] == {
        "problem": {"code": "camera.trouble"},
        "undated": {"code": "drive.undated"},
    }
    assert told["audio"]["problem"] == {"code": "microphone.trouble"}
    assert told["voice"]["problem"] == {"code": "speaker.silent"}
    door = {"name": "Door", "problem": {"code": "camera.trouble"}}
    named = {"code": "camera.named", "values": door}
    assert told["cameras"] == [{"problem": named}, {"problem": None}]
    why = {"code": "tape.stands", "values": {"why": {"code": "tape.trouble"}}}
    assert told["tape"] == {"running": False, "why": why}


def test_working_parts_are_unchanged() -> None:
    """Guests get all the rest of the room's state, and the whole of it while nothing fails."""
    well = room(line(1), line(2), robot=_robot(None))
    assert for_guests(well) == well
    hidden = {"robot", "video", "audio", "voice", "cameras", "tape"}
    failing = _failing(viewers=[line(1)])
    assert for_guests(failing).model_dump(exclude=hidden) == failing.model_dump(exclude=hidden)


def test_a_change_grows_by_nothing() -> None:
    """An unchanged part stays absent, so that a change is small for guests, too."""
    change = room_change.between(_failing(robot=_robot(None)), _failing())
    told = json.loads(room_change.text_of(for_guests(change)))
    assert set(told) == {"type", "viewers", "gone", "robot"}
    assert told["robot"]["problem"] == {"code": "robot.trouble"}


def test_no_hardware_value_reaches_a_guest() -> None:
    """Every sentence about robot, camera, sound or files is covered, present or future."""
    for code in HARDWARE:
        told = for_guests(room(robot=_robot(Sentence(code, {"port": PORT})))).robot.problem
        assert told is not None
        assert told == Sentence("robot.trouble") or not re.search(r"\{", str(CATALOGUE[code]))


@pytest.mark.parametrize("problem", [says(f"cannot open {PORT}"), Sentence("theirs.own")])
def test_only_the_host_reads_a_plug_ins_words(problem: Sentence) -> None:
    """A sentence that this server does not know reaches nobody but the host."""
    assert for_guests(room(robot=_robot(problem))).robot.problem == Sentence("robot.trouble")


@pytest.mark.parametrize("reason", [*RULES, *reasons.ABOARD.values()], ids=lambda one: one.code)
def test_the_sender_reads_what_the_driving_rules_say(reason: Sentence) -> None:
    """The sender of a command, guest or host, reads why it does not count."""
    status = messages.DriveStatus(moving=False, reason=reason, share=0.0)
    assert for_guests(status) == status


def test_operators_and_speakers_read_no_details_either() -> None:
    """The answers to commands, to a voice and to keeping the tape are plain, too."""
    driven = for_guests(messages.DriveStatus(moving=False, reason=LOST, share=0.0))
    assert driven.reason == Sentence("robot.trouble")
    spoken = for_guests(messages.Heard(heard=False, reason=FILE))
    assert spoken.reason == Sentence("speaker.silent")
    stands = Sentence("tape.stands", {"why": Sentence("tape.full")})
    kept = for_guests(messages.Notice(text=Sentence("tape.kept_but", {"but": stands})))
    assert "wax tape" not in str(kept.text)
    assert str(kept.text).endswith("the host is told why.")
    noted = messages.Notice(text=Sentence("queue.not_invited"))
    assert for_guests(noted) == noted
