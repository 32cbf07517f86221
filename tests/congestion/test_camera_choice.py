"""The choice for additional cameras: they share what is left, the large one first."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.allocation import Step
from wax.congestion.camera_choice import CameraChoice
from wax.congestion.wire_cost import picture_bps

LADDER = [
    Step("large", "640x480", 15, 500_000, 2),
    Step("middle", "320x240", 15, 200_000, 2),
    Step("small", "160x120", 5, 30_000, 2),
]
SMALL = LADDER[-1:]
PLENTY_BPS = 20e6


def _names(chosen: list[Step | None]) -> list[str | None]:
    return [None if one is None else one.name for one in chosen]


class Viewer:
    """A viewer's cameras over time; `wishes` are the ones that are watched."""

    def __init__(self, *wishes: list[Step]) -> None:
        self.wishes = list(wishes)
        self.choice = CameraChoice()
        self.now_s = 100.0

    def after(
        self, seconds: float, left_bps: float, kept_bps: float | None = None
    ) -> list[str | None]:
        chosen: list[Step | None] = []
        for _ in range(max(round(seconds * 10), 1)):
            self.now_s += 0.1
            chosen = self.choice.decide(
                self.wishes,
                left_bps=left_bps,
                kept_bps=left_bps if kept_bps is None else kept_bps,
                rate_bps=PLENTY_BPS,
                now_s=self.now_s,
            )
        return _names(chosen)


def test_the_large_one_gets_the_best_and_others_stay_small() -> None:
    """On a fast link each camera gets its best step."""
    assert Viewer(SMALL, LADDER, SMALL).after(2, PLENTY_BPS) == ["small", "large", "small"]


def test_nothing_is_sent_that_nobody_looks_at() -> None:
    """A camera without a wish costs nothing."""
    assert Viewer([], LADDER).after(2, PLENTY_BPS) == [None, "large"]


def test_all_are_seen_before_one_is_large() -> None:
    """The rest of the rate goes to a small picture of each camera first, then to the large one."""
    assert Viewer(SMALL, LADDER).after(2, 300_000) == ["small", "middle"]
    assert Viewer(SMALL, LADDER).after(2, 80_000) == ["small", "small"]
    assert Viewer(SMALL, LADDER).after(2, 50_000) == [None, "small"]


def test_nothing_left_is_nothing_sent() -> None:
    """If the driving view takes everything, the other cameras are dropped."""
    viewer = Viewer(SMALL, LADDER)
    assert viewer.after(2, 0) == [None, None]
    assert viewer.after(2, PLENTY_BPS) == ["small", "large"]
    assert viewer.after(0.1, 0) == [None, None]


def test_they_stay_while_they_are_kept() -> None:
    """Cameras already sent continue while they fit, even if they could not start now."""
    viewer = Viewer(SMALL)
    assert viewer.after(2, PLENTY_BPS) == ["small"]
    assert viewer.after(5, 0, 60_000) == ["small"]
    assert viewer.after(0.1, 0, 10_000) == [None]


def test_a_swap_does_not_wait() -> None:
    """A viewer who enlarges another camera gets it at the next decision."""
    viewer = Viewer(SMALL, LADDER)
    viewer.after(2, PLENTY_BPS)
    viewer.wishes = [LADDER, SMALL]
    assert viewer.after(0.1, PLENTY_BPS) == ["large", "small"]


def test_too_much_too_often_waits_longer() -> None:
    """If they fit only until they are sent, trials become ever rarer."""
    viewer = Viewer(SMALL)
    begun = 0
    was_sent = False
    for _ in range(600):
        is_sent = viewer.after(0.1, 0 if was_sent else 60_000, 0 if was_sent else 60_000) != [None]
        begun += is_sent and not was_sent
        was_sent = is_sent
    assert 3 <= begun <= 7, f"{begun} times a minute"
    viewer.wishes = [LADDER]
    assert viewer.after(0.1, PLENTY_BPS) == [None], "a swap is no way around it"


@given(
    st.lists(
        st.tuples(
            st.sampled_from([[], SMALL, LADDER]),
            st.floats(-1e6, 5e6),
            st.floats(-1e6, 5e6),
            st.floats(8e3, 2e7),
        ),
        max_size=60,
    )
)
def test_never_more_than_is_left_or_kept(
    history: list[tuple[list[Step], float, float, float]],
) -> None:
    """Whatever is wished for, what is sent fits into what the driving view leaves."""
    choice = CameraChoice()
    for at, (wish, left_bps, kept_bps, rate_bps) in enumerate(history):
        wishes = [wish, SMALL]
        chosen = choice.decide(
            wishes, left_bps=left_bps, kept_bps=kept_bps, rate_bps=rate_bps, now_s=at / 2
        )
        costs_bps = sum(picture_bps(one, 0, rate_bps) for one in chosen if one)
        assert costs_bps <= max(left_bps, kept_bps, 0.0)
        assert all(one is None or one in wished for one, wished in zip(chosen, wishes, strict=True))
