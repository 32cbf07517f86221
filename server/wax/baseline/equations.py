"""Equations (3.1) to (3.4) of the thesis, with their boundaries."""

from __future__ import annotations

import math


def hold_back_s(first_sound_captured_s: float, newest_picture_captured_s: float) -> float:
    """Return T_p, how long the newest picture is held back to match the first sound (3.1).

    Never negative: sound younger than the picture needs no hold-back.
    """
    return max(0.0, newest_picture_captured_s - first_sound_captured_s)


def pictures_to_cache(transfer_ms: float, *, audio_mu_ms: int, video_mu_ms: int) -> int:
    """Return N_v, the capacity of a viewer's picture cache, rounded down.

    With A and V the lengths of the media units and T_r the time that a picture takes:
    T_r < V gives A / V - 1 (3.2); V <= T_r < A gives A / T_r - 1 (3.3); T_r >= A gives 0 (3.4).
    The thesis leaves T_r = V open, where (3.2) and (3.3) agree.

    The worked example of 3.3.4 (A = 400, T_r = 200, two buffers) contradicts (3.3), which gives
    one; this follows the equation. On the left of (3.3) the thesis prints V_2, but according to
    the text around it means N_v.

    Raises `ValueError` unless A is a whole multiple of V and T_r is a time.
    """
    if video_mu_ms <= 0 or audio_mu_ms <= 0 or audio_mu_ms % video_mu_ms:
        raise ValueError("the audio MU must be a whole multiple of the video MU")
    if math.isnan(transfer_ms) or transfer_ms < 0:
        raise ValueError("the time that a picture takes must not be negative")
    if transfer_ms < video_mu_ms:
        return audio_mu_ms // video_mu_ms - 1
    if transfer_ms < audio_mu_ms:
        return int(audio_mu_ms // transfer_ms) - 1
    return 0
