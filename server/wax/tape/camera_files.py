"""Writes the pictures of all cameras but the driving view in one part, a file for each camera.

Each has its own file, because a browser shows one video track of a file, WebM cannot hold H.264,
and a camera without pictures must not stall another. Time 0 is the camera's first keyframe.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.tape.shelf import camera_ending
from wax.tape.tape_file import ENDINGS, TapeFile

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.encode.encoded import EncodedPicture
    from wax.tape.shelf import Shelf
    from wax.tape.tape_file import Codec


@dataclass(frozen=True, slots=True)
class CameraFormat:
    """A camera's name for people, and the codec and size of its pictures."""

    name: str
    codec: Codec
    size: tuple[int, int]


class CameraFiles:
    """The camera files of the part `name`; cameras count from 1, in the order of `cameras`.

    Only `has` is thread-safe; all other methods may raise `OSError` or `av.FFmpegError`.
    """

    def __init__(
        self, shelf: Shelf, name: str, cameras: Sequence[CameraFormat], *, origin_s: float
    ) -> None:
        self._shelf = shelf
        self._name = name
        self._cameras = cameras
        self._origin_s = origin_s
        self._files: dict[int, TapeFile] = {}

    def has(self, camera: int) -> bool:
        """Return whether this camera's file has been started."""
        return camera in self._files

    def picture(self, camera: int, picture: EncodedPicture) -> bool:
        """Add a picture to its file, which a keyframe starts; return whether this one did."""
        file = self._files.get(camera)
        begins = file is None and picture.keyframe and picture.captured_s >= self._origin_s
        if begins:
            file = self._files[camera] = self._start_file(camera, picture.captured_s)
        if file is not None:
            file.picture(picture)
        return begins

    def sync(self) -> None:
        """Sync to disk, so that a power cut loses only the newest pictures."""
        for file in self._files.values():
            file.sync()

    def close(self) -> None:
        """Finish all files, even if one of them fails."""
        with ExitStack() as closing:
            for file in self._files.values():
                closing.callback(file.close)

    def _start_file(self, camera: int, origin_s: float) -> TapeFile:
        camera_format = self._cameras[camera - 1]
        return TapeFile(
            self._shelf.path(self._name, camera_ending(camera, ENDINGS[camera_format.codec])),
            codec=camera_format.codec,
            size=camera_format.size,
            has_sound=False,
            origin_s=origin_s,
        )
