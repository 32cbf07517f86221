"""The capture time of a live stream's pictures: what stamps may add to their arrival."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.examples import examples

from wax.capture.stream_dating import LIVE_WITHIN_S, Dating, Repeats


@dataclass
class Sender:
    """Sends pictures to a dating; `jam_s` is the present delay of the backlog."""

    dating: Dating = field(default_factory=lambda: Dating(stamped=True))
    now_s: float = 100.0
    arrived_s: float = 0.0
    jam_s: float = 0.0
    known: bool = False

    def send(self, stamp_s: float, *, track: int = 0, decoded: bool = True) -> float:
        """Send the picture that is captured now; return its estimated age on arrival."""
        self.arrived_s = max(self.arrived_s, self.now_s + self.jam_s)
        zero_s, within_s = self.dating.date(
            track, stamp_s, stamp_s if decoded else None, self.arrived_s
        )
        self.known = within_s is not None
        return self.arrived_s - (zero_s + stamp_s)


RATES = [5.0, 10.0, 15.0, 20.0, 30.0, 60.0]


@pytest.mark.parametrize("fps", RATES)
def test_made_up_stamps_are_not_believed(fps: float) -> None:
    """Without a clock in the container, which claims 25 fps, arrival alone dates each picture."""
    sender = Sender(Dating(stamped=False))
    for number in range(200):
        assert sender.send(number / 25) == pytest.approx(0.0, abs=1e-9)
        sender.now_s += 1 / fps
    assert sender.known


@examples(100)
@given(
    st.sampled_from(RATES),
    st.sampled_from([1.0, 1.0, 0.999, 0.9999, 1.001, 1.02]),
    st.lists(st.floats(0.0, 0.05), min_size=5, max_size=20),
    st.lists(
        st.tuples(
            st.sampled_from(["stand", "jump", "back", "wrap", "none", "run"]),
            st.integers(1, 60),
            st.floats(0.6, 50_000.0),
        ),
        max_size=5,
    ),
)
@example(5.0, 1.0, [0.0], [("jump", 1, 1.5), ("back", 1, 2.0)])
def test_stamps_that_misbehave_cost_no_age(
    fps: float, clock: float, jitter_s: list[float], faults: list[tuple[str, int, float]]
) -> None:
    """Stuck, jumping, wrapping, missing or slightly wrong stamps date within 60 ms, never young."""
    sender = Sender()
    stamp_s, count = 0.0, 0

    def send(*, steps: bool = True, decoded: bool = True) -> None:
        nonlocal stamp_s, count
        sender.jam_s = jitter_s[count % len(jitter_s)]
        age_s = sender.send(stamp_s, decoded=decoded)
        true_s = sender.arrived_s - sender.now_s
        assert age_s >= -1e-9, "later than its arrival"
        assert age_s <= true_s + 0.06
        sender.now_s += 1 / fps
        stamp_s += clock / fps if steps else 0.0
        count += 1

    for what, pictures, by_s in [("run", 90, 0.0), *faults, ("run", 60, 0.0)]:
        match what:
            case "jump":
                stamp_s += by_s
            case "back":
                stamp_s -= by_s
            case "wrap":
                stamp_s -= 2**33 / 90_000
        for _ in range(pictures):
            send(steps=what != "stand", decoded=what != "none")


def test_a_jam_is_seen() -> None:
    """A backlog ages pictures by its delay, however long it lasts, and no longer once it drains."""
    sender = Sender()
    for number in range(9000):
        age_s = sender.send(number / 30)
        assert age_s == pytest.approx(sender.arrived_s - sender.now_s, abs=0.15)
        sender.now_s += 1 / 30
        # The backlog builds up, stays for four minutes, and drains.
        if 600 < number < 900:
            sender.jam_s += 1 / 300
        elif number > 8100:
            sender.jam_s = 0.0
    assert age_s < 0.001


def test_after_a_stall_what_has_waited_is_not_new() -> None:
    """After a stall of 3 s pictures are of unknown age until they are live again."""
    sender = Sender()
    for number in range(300):
        sender.jam_s = max(0.0, 3.0 - (number - 150) / 30) if number >= 150 else 0.0
        age_s = sender.send(number / 30)
        true_s = sender.arrived_s - sender.now_s
        assert not sender.known or age_s == pytest.approx(true_s, abs=0.01)
        if number > 30 and not 230 < number < 240:
            assert sender.known == (not 150 <= number < 235)
        sender.now_s += 1 / 30


@pytest.mark.parametrize("claimed_fps", [12.5, 25.0])
def test_a_clock_of_another_speed_is_nobodys(claimed_fps: float) -> None:
    """Stamps of 25 fps on 10 fps, which look like a backlog, soon make the age unknown."""
    sender = Sender()
    known = []
    for number in range(400):
        age_s = sender.send(number / claimed_fps)
        known.append(sender.known)
        assert age_s <= 2.1
        sender.now_s += 0.1
    assert not any(known[130:])
    assert age_s == pytest.approx(0.0)  # viewers still get it in step


def test_by_datagrams_a_clock_of_another_speed_is_given_up() -> None:
    """Over datagrams, which queue for no 10 s, such stamps are dropped, and arrival counts."""
    sender = Sender(Dating(stamped=True, queues=False))
    for number in range(1600):
        age_s = sender.send(number / 25)
        sender.now_s += 1 / 21  # like a camera that claims 25 fps and sends 21
    assert sender.known
    assert age_s == pytest.approx(0.0)


def test_a_picture_stamped_hours_away_disturbs_no_other() -> None:
    """A recorder that stamps one picture in fifty hours off ages neither it nor the next."""
    sender = Sender()
    for number in range(600):
        sender.jam_s = 0.04 if number >= 60 else 0.0
        off_s = (-9_800.0, 37_600.0)[number // 50 % 2] if number % 50 == 49 else 0.0
        assert sender.send(number / 25 + off_s) == pytest.approx(sender.jam_s, abs=0.015)
        sender.now_s += 1 / 25
    assert sender.known


@pytest.mark.parametrize("clock", [0.996, 0.999, 1.004])
def test_a_clock_that_is_a_little_wrong_is_followed(clock: float) -> None:
    """A camera that stamps 24.9 fps as 25 fps is no older after ten minutes."""
    sender = Sender()
    ages_s = []
    for number in range(15_000):
        sender.jam_s = 0.01 * (number * 7 % 5)
        ages_s.append(sender.send(clock * number / 25))
        sender.now_s += 1 / 25
    assert max(ages_s) < 0.17
    assert sum(ages_s[-100:]) / 100 < 0.08


def test_sound_and_picture_jump_together() -> None:
    """After a stream restarts its stamps, sound and picture are in step as before."""
    sender = Sender()
    jumped_s = 0.0
    for number in range(400):
        if number == 200:
            jumped_s = -1000.0
        sender.jam_s = 0.2
        picture_s = sender.send(number / 25 + jumped_s, track=0)
        sound_s = sender.send(number / 25 + 0.18 + jumped_s, track=1)
        assert sound_s == pytest.approx(0.0, abs=0.005)
        assert number == 0 or picture_s == pytest.approx(0.18, abs=0.005)
        sender.now_s += 1 / 25


def test_what_comes_first_is_nobodys() -> None:
    """A server may send a stored picture first: the age is unknown until the stream is live."""
    dating = Dating(stamped=False)
    assert dating.date(0, 0.0, 0.0, 5.0)[1] is None
    assert dating.date(0, 0.1, 0.1, 5.9)[1] is None
    assert dating.date(0, 0.2, 0.2, 6.0)[1] == LIVE_WITHIN_S


def test_repetitions_are_not_new() -> None:
    """Repeated content is "again" for a second, and then "old" until it changes."""
    repeats = Repeats()
    came = [repeats.of(one, at_s) for one, at_s in [(b"a", 1), (b"a", 1.9), (b"a", 2), (b"b", 2.1)]]
    assert came == ["new", "again", "old", "new"]
