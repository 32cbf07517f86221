"""A picture in a file's format."""

from __future__ import annotations

import cv2
import numpy as np


def encoded(kind: str, width: int = 120, height: int = 63) -> bytes:
    picture = np.full((height, width, 3), 90, np.uint8)
    done, content = cv2.imencode(f".{kind}", picture)
    assert done
    return content.tobytes()
