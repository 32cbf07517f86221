"""Others' tapes, truncated or damaged: what can be read, or one sentence that names the file.

A browser gets JSON with valid numbers, and a complete copy.
"""

from __future__ import annotations

import json
import tempfile
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Final
from zlib import crc32

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC
from tests.fuzz.target import Target
from tests.tape.packets import SIZE, pictures, sounds

from wax.errors import StateError
from wax.protocol.tape_events import (
    FORMAT,
    Filmed,
    Missed,
    Named,
    Steered,
    Stopped,
    TapeContent,
    Turned,
)
from wax.tape.event_file import METADATA, ORIGIN, VERSION, EventFile
from wax.tape.reading import read_events
from wax.tape.repaired import facts_of, repaired
from wax.tape.tape_file import ENDINGS, TapeFile

if TYPE_CHECKING:
    from wax.tape.tape_file import Codec

_BEGIN_S: Final = 1000.0
_SECONDS: Final = 0.2
_FOLDER: Final = tempfile.TemporaryDirectory(prefix="wax-fuzz-tapes-")
_MADE: Final = Path(_FOLDER.name)
_STEERED: Final = Steered(
    turn=3,
    linear_mps=0.1,
    angular_rps=0.0,
    wanted_linear_mps=0.2,
    wanted_angular_rps=0.0,
    reason=None,
    limit=None,
    lateral_mps=-0.1,
    wanted_lateral_mps=-0.2,
)


def _events() -> bytes:
    path = _MADE / "seed.mcap"
    made = EventFile(path, origin_s=_BEGIN_S, zero_ns=10**18)
    made.write(Turned(number=3, operator=7, why=None), _BEGIN_S)
    made.write(Named(viewer=7, name="Ada"), _BEGIN_S)
    made.write(Filmed(camera=1, name="Door"), _BEGIN_S + 0.1)
    made.write(_STEERED, _BEGIN_S + 0.2)
    made.flush()
    made.write(Stopped(number=1, pressed=True, viewer=2, by_host=False), _BEGIN_S + 3.0)
    made.write(Missed(missed_s=1.5), _BEGIN_S + 4.0)
    made.close()
    return path.read_bytes()


def _media(codec: Codec) -> bytes:
    path = _MADE / f"seed{ENDINGS[codec]}"
    made = TapeFile(path, codec=codec, size=SIZE, has_sound=True, origin_s=_BEGIN_S)
    for picture in pictures(codec, begin_s=_BEGIN_S, seconds=_SECONDS):
        made.picture(picture)
    for sound in sounds(begin_s=_BEGIN_S, seconds=_SECONDS):
        made.sound(sound)
    made.close()
    return path.read_bytes()


def _records() -> bytes:
    """Return the compressed records in the first piece of a tape."""
    reader = StreamReader(BytesIO(EVENTS.seeds[0]), emit_chunks=True)
    chunk = next(one for one in reader.records if isinstance(one, Chunk))
    return zstandard.decompress(chunk.data)


def _packed(data: bytes) -> bytes:
    """Return a tape that is truncated after one piece with these records, whatever they are."""
    builder = RecordBuilder()
    Metadata(METADATA, {VERSION: str(FORMAT), ORIGIN: str(10**18)}).write(builder)
    Chunk(
        compression="zstd",
        data=zstandard.compress(data),
        message_start_time=0,
        message_end_time=0,
        uncompressed_crc=crc32(data),
        uncompressed_size=len(data),
    ).write(builder)
    piece: bytes = builder.end()  # type: ignore[no-untyped-call]  # the library leaves it out
    return MCAP0_MAGIC + piece


def _hear_events(data: bytes) -> None:
    path = _MADE / "part.mcap"
    path.write_bytes(data)
    try:
        read = read_events(path)
    except StateError as error:
        _names(error, path)
        return
    content = TapeContent(
        name="part",
        began_wall_ms=read.began_wall_ms,
        length_ms=read.length_ms,
        has_media=False,
        has_picture=False,
        has_sound=False,
        cameras=[],
        events=read.events,
        problem=read.problem,
    )
    json.loads(content.model_dump_json(), parse_constant=_is_no_number)


def _hear_media(data: bytes) -> None:
    path, copies = _MADE / "part.webm", _MADE / "copies"
    path.write_bytes(data)
    copies.mkdir(exist_ok=True)
    facts = facts_of(path)
    assert facts.length_ms >= 0
    try:
        playable = repaired(path, copies)
    except StateError as error:
        _names(error, path)
    else:
        assert playable in (path, copies / path.name)
    finally:
        for one in copies.iterdir():
            one.unlink()
    assert path.read_bytes() == data, "the tape was changed"


def _names(error: StateError, path: Path) -> None:
    assert str(error).startswith(str(path)), "a sentence that does not name the file"


def _is_no_number(constant: str) -> None:
    raise AssertionError(f"{constant} is no number of JSON")


EVENTS: Final = Target(
    name="tape-events",
    what="events of a tape",
    hear=_hear_events,
    seeds=(_events(),),
    words=(
        b"zstd", b"lz4", b"wax.tape", b"origin_ns", b"format", b"/wax/missed", b"NaN", b"null",
        b"\x28\xb5\x2f\xfd", b"\x06", b"\x05", b"\x0c", b"\xff" * 8, b"\x89MCAP0\r\n",
    ),
    max_bytes=16_384,
    inputs=1500,
)  # fmt: skip
RECORDS: Final = Target(
    name="tape-records",
    what="records in a piece of a tape",
    hear=lambda data: _hear_events(_packed(data)),
    seeds=(_records(),),
    words=(
        b"/wax/missed", b'"missed_s":', b'"lateral_mps":', b'"type":"watched"', b"NaN", b"1e999",
        b"null", b"true", b"[" * 60, b'{"a":' * 40, b'"\\u0000"', b"\x03", b"\x04", b"\x05",
        b"\xff" * 8,
    ),
    max_bytes=8192,
    inputs=4000,
)  # fmt: skip
MEDIA: Final = Target(
    name="tape-media",
    what="picture and sound of a tape",
    hear=_hear_media,
    seeds=tuple(_media(codec) for codec in ENDINGS),
    words=(
        b"\x1a\x45\xdf\xa3", b"\x18\x53\x80\x67", b"\x1f\x43\xb6\x75", b"\x44\x89", b"\xa3",
        b"webm", b"moof", b"moov", b"mdat", b"tfhd", b"trun", b"ftyp", b"\xff" * 8,
    ),
    max_bytes=16_384,
    inputs=1500,
)  # fmt: skip
