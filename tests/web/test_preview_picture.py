"""The picture for previews is checked at the start, and refused with one sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from tests.web.pictures import encoded

from wax.errors import ConfigError
from wax.web import preview_picture

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize(
    ("kind", "content_type"),
    [("png", "image/png"), ("jpg", "image/jpeg"), ("webp", "image/webp")],
)
def test_a_pictures_content_decides_its_type(kind: str, content_type: str, tmp_path: Path) -> None:
    """The file's name does not matter; the size is read, too."""
    file = tmp_path / "robot.picture"
    file.write_bytes(encoded(kind))
    found = preview_picture.read(str(file))
    assert found is not None
    assert (found.content_type, found.width, found.height) == (content_type, 120, 63)
    assert found.content == file.read_bytes()


def test_another_picture_has_another_digest(tmp_path: Path) -> None:
    """Browsers cache it for good, so a changed picture needs another URL."""
    digests = set()
    for width in (120, 122):
        file = tmp_path / "robot.png"
        file.write_bytes(encoded("png", width))
        found = preview_picture.read(str(file))
        assert found is not None
        digests.add(found.digest)
    assert len(digests) == 2


def test_no_picture_is_no_problem() -> None:
    """The key is empty by default."""
    assert preview_picture.read("") is None


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "does not exist"),
        (b"", "is no PNG, JPEG or WebP picture"),
        (b"GIF89a" + b"\0" * 99, "is no PNG, JPEG or WebP picture"),
        (b"<svg xmlns='http://www.w3.org/2000/svg'/>", "is no PNG, JPEG or WebP picture"),
        (encoded("png")[:60], "is no PNG, JPEG or WebP picture"),
        (encoded("png") + b"\0" * (1 << 20), "has 1.0 MiB, and 1 MiB is the most; make it smaller"),
    ],
)
def test_an_invalid_picture_is_refused(content: bytes | None, says: str, tmp_path: Path) -> None:
    """The sentence names the key, the file and what is wrong with it."""
    file = tmp_path / "robot.png"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ConfigError) as refused:
        preview_picture.read(str(file))
    assert str(refused.value).startswith(f"page.picture: {file} {says}")


def test_a_folder_is_no_picture(tmp_path: Path) -> None:
    """A folder is refused, although it exists."""
    with pytest.raises(ConfigError, match="not a file"):
        preview_picture.read(str(tmp_path))
