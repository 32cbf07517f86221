"""Keeps OpenCV to the thread that calls it."""

from __future__ import annotations

import cv2


def keep_in_one_thread() -> None:
    """Have each call of OpenCV use its caller's thread only; call it once in each process.

    On pictures as small as ours, waking and awaiting OpenCV's threads costs more than they save: a
    third of the time of a core that a picture of the simulated flat takes.
    """
    cv2.setNumThreads(1)
