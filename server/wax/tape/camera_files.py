"""The pictures of the cameras beside the driving view in one part: a file for each of them.

A browser shows one picture of a file, WebM holds no H.264, and a file that one camera leaves empty
must not hold up another: so each has its own. It begins at 0 with the camera's first keyframe.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.tape.media_file import ENDINGS, TapeFile
from wax.tape.shelf import beside

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.encode.encoded import EncodedPicture
    from wax.tape.media_file import Codec
    from wax.tape.shelf import Shelf


@dataclass(frozen=True, slots=True)
class CameraFormat:
    """What people call a camera, and what its pictures are like."""

    name: str
    codec: Codec
    size: tuple[int, int]


class CameraFiles:
    """Cameras count from 1, in the order of `cameras`; `name` is that of the part.

    Not thread-safe but for `has`. All methods but that may raise `OSError` or `av.FFmpegError`.
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
        """Whether the file of this camera has begun."""
        return camera in self._files

    def picture(self, camera: int, picture: EncodedPicture) -> bool:
        """Add a picture, if its file has begun or this can begin it; return whether it did."""
        file = self._files.get(camera)
        begins = file is None and picture.keyframe and picture.captured_s >= self._origin_s
        if begins:
            file = self._files[camera] = self._begin(camera, picture.captured_s)
        if file is not None:
            file.picture(picture)
        return begins

    def sync(self) -> None:
        """Have all but the newest pictures outlast a power cut."""
        for file in self._files.values():
            file.sync()

    def close(self) -> None:
        """Finish all files, also where one of them fails."""
        with ExitStack() as closing:
            for file in self._files.values():
                closing.callback(file.close)

    def _begin(self, camera: int, origin_s: float) -> TapeFile:
        camera_format = self._cameras[camera - 1]
        return TapeFile(
            self._shelf.path(self._name, beside(camera, ENDINGS[camera_format.codec])),
            codec=camera_format.codec,
            size=camera_format.size,
            has_sound=False,
            origin_s=origin_s,
        )
