"""Several flows over one bottleneck, and cells whose rate walks: what each viewer gets."""

from __future__ import annotations

import pytest
from tests.ablation.links import beside_download, beside_viewer, carried_bps, cellular, network
from tests.ablation.traffic import rate_bps, starved_s
from tests.congestion.bottleneck import Port, TcpDownload, bottleneck, run
from tests.examples import at_length
from tests.link.profile import load
from tests.sync.link_model import Loop, default_steps

LADDER = [*default_steps(), None]


def test_two_downloads_fill_a_bottleneck_and_share_it() -> None:
    """The TCP model fills the link alone, and leaves a second flow at least a third."""
    link = network("shared", rate_bps=2_000_000, queue_ms=100.0, delay_ms=20.0)
    pipe = bottleneck(link, seed=1, start_s=100.0)
    first = TcpDownload(Port(pipe), back_s=0.02, begin_s=100.0)
    second = TcpDownload(Port(pipe), back_s=0.02, begin_s=105.0)
    run([first, second], 125.0)
    assert first.rate_bps(101, 105) >= 0.95 * 2e6
    shares = [one.rate_bps(110, 125) for one in (first, second)]
    assert sum(shares) >= 0.95 * 2e6
    assert min(shares) >= sum(shares) / 3


@pytest.mark.parametrize("seed", [1, *at_length(*range(2, 7))])
@pytest.mark.parametrize("link_bps", [400_000, *at_length(800_000, 2_000_000)])
def test_two_viewers_are_at_most_a_step_apart(link_bps: int, seed: int) -> None:
    """The later viewer ends at the same step of the ladder or the next, and neither starves.

    On a thin bottleneck the next smaller step needs half the rate, so one viewer may get half of
    what the other gets if no larger step fits.
    """
    first, second = beside_viewer(seed, rate_bps=link_bps, begin_s=10.0, run_s=40.0)
    steps = [LADDER.index(one.record.changes()[-1][1]) for one in (first, second)]
    assert abs(steps[0] - steps[1]) <= 1
    if link_bps < 1_000_000:
        shares = [rate_bps(first, 20.0, 40.0), rate_bps(second, 10.0, 30.0)]
        assert min(shares) >= 0.5 * max(shares)
    assert starved_s(first, 20.0, 40.0) == 0
    assert starved_s(second, 10.0, 30.0) == 0
    assert first.record.sound_ms(20.0, 40.0, 0.95) <= 120
    assert second.record.sound_ms(10.0, 30.0, 0.95) <= 120


@pytest.mark.parametrize("link_bps", [1_000_000, *at_length(3_000_000)])
def test_a_download_never_silences_a_viewer(link_bps: int) -> None:
    """During a download that fills the queue, sound is at most as late as the queue is long."""
    loop, download = beside_download(1, rate_bps=link_bps, begin_s=6.0, end_s=20.0, run_s=20.0)
    own_ms = 20 + 24  # the route's delay, and the length of a packet of sound
    assert loop.record.sound_ms(8.0, 20.0, 1.0) <= own_ms + 300
    assert len([at_s for at_s, _ in loop.record.sounds if 8.0 <= at_s < 20.0]) >= 0.9 * 12 / 0.12
    assert download.rate_bps(110.0, 120.0) >= 0.9 * link_bps


@pytest.mark.parametrize("seed", [1, *at_length(*range(2, 7))])
def test_a_picture_returns_after_a_download_on_a_modem_line(seed: int) -> None:
    """The download leaves the estimate at the sound's rate, which only a trial can raise."""
    modem = load("modem-56k")
    pipe = bottleneck(modem, seed=seed, start_s=100.0)
    loop = Loop(modem, down=Port(pipe), feedback_s=0.05, seed=seed)
    download = TcpDownload(Port(pipe), back_s=0.07, begin_s=101.0, end_s=105.0)
    run([loop, download], 160.0)
    assert starved_s(loop, 1.0, 20.0) > 0
    assert starved_s(loop, 30.0, 60.0) == 0


@pytest.mark.parametrize("link_bps", [24_000, *at_length(28_000)])
def test_tries_delay_no_sound_for_long(link_bps: int) -> None:
    """If the link carries only the sound, a picture is tried seldom and briefly."""
    link = network("thin", rate_bps=link_bps, queue_ms=1500.0, delay_ms=60.0)
    loop = Loop(link, feedback_s=0.05)
    loop.run(60)
    assert loop.record.sound_ms(20.0, 60.0, 0.9) <= 60 + 200


@pytest.mark.parametrize("seed", [1, *at_length(2, 3)])
def test_a_cell_is_followed(seed: int) -> None:
    """While the rate walks from 0.15 to 6 Mbit/s, pictures stay fresh and most of it is used."""
    cell = cellular(seed=seed, seconds=30)
    loop = Loop(cell, feedback_s=0.05)
    loop.run(30)
    assert rate_bps(loop, 4.0, 30.0) >= 0.5 * carried_bps(cell, 4.0, 30.0)
    assert starved_s(loop, 4.0, 30.0) == 0
    assert loop.record.sound_ms(4.0, 30.0, 0.95) <= 150
    assert loop.record.picture_ms(4.0, 30.0, 0.95) <= 300
