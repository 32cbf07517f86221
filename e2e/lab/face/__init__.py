"""The talking face: speech with a drawn mouth that follows it, and how the two are judged by it."""

from e2e.lab.face.film import face_file
from e2e.lab.face.lips import LipLag, lip_lag

__all__ = ["LipLag", "face_file", "lip_lag"]
