"""One viewer under the live policies: what is sent, and when it plays."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.streams.live_rig import BOTTOM, TOP, Rig

from wax.capture.source import BLOCK_SAMPLES, Sound
from wax.config.sync import SyncSettings
from wax.encode.rendition import Rendition
from wax.protocol import messages
from wax.sentence import Sentence
from wax.streams.interface import SendingLimits

if TYPE_CHECKING:
    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.streams.interface import Policy

OPERATOR = SyncSettings(max_holdback_ms=50.0, max_skew_ms=100.0, least_audio_mu_ms=10)


async def test_a_picture_starts_small_and_grows_at_once() -> None:
    """The first picture has the smallest rendition; a fast link soon has the largest."""
    rig = Rig()
    rig.begin()
    assert rig.video.wanted == [BOTTOM]
    await rig.run(2.0)
    assert rig.video.wanted == [TOP]
    assert rig.sizes[0] == BOTTOM
    assert rig.sizes[-1] == TOP


async def test_two_channels_are_sent_while_there_are_two() -> None:
    """When a channel fails mono is sent at once, and stereo seconds after it recovers."""
    rig = Rig(channels=2)
    rig.begin()
    await rig.run(4.0)
    assert rig.streams.status().entry["sound_channels"] == 2
    assert rig.all(messages.Served)[-1].sound_channels == 2
    rig.channels = 1
    await rig.run(1.0)
    assert rig.streams.status().entry["sound_channels"] == 1
    assert all("stereo" not in name for name in rig.audio.wanted)
    rig.channels = 2
    await rig.run(8.0)
    assert rig.streams.status().entry["sound_channels"] == 2


async def test_a_thin_link_has_one_channel() -> None:
    """If stereo does not fit into the sound's third, packets of the same length are mono."""
    rig = Rig(rate_bps=110e3, channels=2)
    rig.begin()
    await rig.run(4.0)
    assert rig.streams.status().entry["sound_channels"] == 1


async def test_another_network_gets_a_fresh_start() -> None:
    """On a new network the queue is dropped and the smallest rendition starts to grow again."""
    rig = Rig()
    rig.begin()
    await rig.run(2.0)
    rig.video._fan_out(rig._picture(TOP, rig.clock.now_s()))
    assert not rig.lane.is_empty
    rig.asked.clear()
    rig.sizes.clear()
    rig.streams.link_changed()
    rig._feedback.clear()
    await rig.run(0.05)
    assert rig.asked[0] == rig.sizes[0] == BOTTOM
    await rig.run(2.0)
    assert rig.sizes[-1] == TOP


async def test_after_a_thin_link_another_network_grows_as_usual() -> None:
    """The first keyframe after a slow link is of the same rendition."""
    rig = Rig(rate_bps=50e3)
    rig.begin()
    await rig.run(4.0)
    assert rig.streams.status().entry["rendition"] == BOTTOM
    rig.asked.clear()
    rig.streams.link_changed()
    rig.streams.keyframe_wanted()
    rig.rate_bps = 20e6
    await rig.run(0.05)
    assert rig.asked == [BOTTOM]
    await rig.run(2.0)
    assert rig.sizes[-1] == TOP


async def test_a_thin_link_stays_with_what_it_carries() -> None:
    """A modem gets the smallest rendition and long units of sound, without a queue."""
    rig = Rig(rate_bps=50e3)
    rig.begin()
    await rig.run(6.0)
    served = rig.streams.status().entry
    assert served["rendition"] == BOTTOM
    assert served["sound_mu_ms"] == 60
    assert float(str(served["queue_ms"])) < 400


async def test_files_wait_on_a_thin_link_alone() -> None:
    """On a slow link congestion control paces files; on others they are sent whole."""
    for rate_bps, waits in ((50e3, True), (5e6, False)):
        rig = Rig(rate_bps=rate_bps)
        rig.begin()
        await rig.run(3.0)
        assert (rig.streams.file_sent(200) is not None) == waits


async def test_a_link_that_narrows_gets_a_fresh_start_with_less() -> None:
    """On a shrinking link the queue is dropped and a smaller rendition starts with a keyframe."""
    rig = Rig(rate_bps=8e6)
    rig.begin()
    await rig.run(4.0)
    assert rig.sizes[-1] == TOP
    rig.rate_bps = 300e3
    rig.sizes.clear()
    await rig.run(4.0)
    later = [name for name in rig.sizes if name != TOP]
    assert later
    assert rig.sizes[-1] != TOP
    assert rig.sizes == sorted(rig.sizes, key=lambda name: name != TOP)


async def test_a_short_upload_is_shared_whatever_the_links_carry() -> None:
    """A viewer gets the whole upload alone, half of it beside another, and the reason."""
    rig = Rig(upload_bps=640_000)
    rig.begin()
    await rig.run(8.0)
    alone = rig.streams.status().entry
    assert alone["rendition"] == "320x240 at 300 kbit/s"
    assert alone["reason"] == "your share of what the robot can send is about 580 kbit/s"
    assert rig.service.has_room
    other = rig.service.streams(rig, SyncSettings())
    other.make_lanes()
    other.want(sound=True, picture=True, size="640x480", policy=None)
    await rig.run(4.0)
    assert rig.streams.status().entry["rendition"] == "320x240 at 120 kbit/s"
    other.release()
    await rig.run(8.0)
    assert rig.streams.status().entry["rendition"] == alone["rendition"]


@pytest.mark.parametrize("drives", [False, True])
async def test_a_late_loop_sends_observers_less(*, drives: bool) -> None:
    """Once the loop is late an observer's picture shrinks; the operator's does not."""
    rig = Rig()
    rig.begin()
    rig.streams.set_role(OPERATOR if drives else SyncSettings(), drives=drives)
    await rig.run(2.0)
    assert rig.sizes[-1] == TOP
    assert rig.service.limits.problems() == []
    for _ in range(20):
        rig.service.relieve(0.03)
        await rig.run(1.0)
    told = [one.code for one in rig.service.limits.problems()]
    assert told == ([] if drives else ["busy.loop"])
    assert (rig.streams.status().entry["rendition"] == TOP) == drives


async def test_a_size_that_is_encoded_too_slowly_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everybody gets the next smaller size, is told why, and the host is told, until it is over."""
    rig = Rig()
    rig.begin()
    rig.streams.set_role(OPERATOR, drives=True)
    await rig.run(2.0)
    assert rig.sizes[-1] == TOP
    monkeypatch.setattr(Rendition, "load", property(lambda one: 1.1 * (one.settings.width > 320)))
    for _ in range(5):
        rig.service.relieve(0.0)
        await rig.run(1.0)
    entry = rig.streams.status().entry
    assert entry["rendition"] == "320x240 at 300 kbit/s"
    assert entry["reason"] == "the robot's computer encodes nothing larger in time just now"
    assert rig.service.limits == SendingLimits(["640x480"], "320x240")
    assert [one.code for one in rig.service.limits.problems()] == ["busy.encoding"]
    monkeypatch.setattr(Rendition, "load", property(lambda _: 0.1))
    rig.clock.time_s += 30.0
    rig.service.relieve(0.0)
    await rig.run(6.0)
    assert rig.sizes[-1] == TOP
    assert rig.service.limits.problems() == []


async def test_messages_are_part_of_a_share_of_the_upload() -> None:
    """Rate that a viewer uses for data channels is not promised to others."""
    rig = Rig(upload_bps=1_400_000)
    rig.begin()
    other = rig.service.streams(rig, SyncSettings())
    drawn = other.make_lanes().congestion
    other.want(sound=True, picture=False, size="640x480", policy=None)
    promised_bps = []
    for size_bytes in (0, 1000):
        for _ in range(40):
            drawn.sent(size_bytes, rig.clock.now_s(), is_media=False)
            await rig.run(0.05)
        promised_bps.append(rig.service._budget.next_bps())
    assert promised_bps[1] < promised_bps[0] - 50_000
    other.release()


async def test_a_full_upload_has_no_room() -> None:
    """Nobody is admitted without rate for a picture; a viewer who leaves makes room."""
    rig = Rig(upload_bps=60_000)
    assert rig.service.has_room
    rig.begin()
    assert not rig.service.has_room
    rig.streams.release()
    assert rig.service.has_room


async def test_what_a_decision_sends_does_not_decide_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A pre-roll that a decision sends does not start another decision."""
    rig = Rig()
    rig.begin()
    await rig.run(2.0)
    for number in range(72):
        rig.audio.push(Sound(np.zeros(BLOCK_SAMPLES, np.int16), rig.clock.now_s() + number / 100))
    lane = rig.streams._sound_lane
    assert lane is not None
    decided: list[float] = []
    decide = rig.streams._allocator.decide

    def counted(*estimates: LinkEstimate, **wanted: Any) -> Allocation:
        decided.append(rig.clock.now_s())
        return decide(*estimates, **wanted)

    def send() -> None:
        while lane.pop_next() is not None:
            rig.clock.time_s += 0.6
            rig.congestion.sent(1200, rig.clock.now_s(), is_media=True)

    monkeypatch.setattr(rig.streams._allocator, "decide", counted)
    rig.streams.want(sound=False, picture=True, size="640x480", policy=None)
    lane.set_listener(send)
    decided.clear()
    began_s = rig.clock.now_s()
    rig.streams.want(sound=True, picture=True, size="640x480", policy=None)
    assert rig.clock.now_s() > began_s, "nothing was sent ahead"
    assert len(decided) == 1
    rig.congestion.sent(1200, rig.clock.now_s() + 0.6, is_media=True)
    assert len(decided) == 2


async def test_a_settled_link_is_decided_on_a_few_times_a_second(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """However often feedback comes, a link that is no worse waits; a wish does not."""
    rig = Rig()
    rig.begin()
    await rig.run(6.0)
    decided: list[float] = []
    decide = rig.streams._allocator.decide

    def counted(*estimates: LinkEstimate, **wanted: Any) -> Allocation:
        decided.append(rig.clock.now_s())
        return decide(*estimates, **wanted)

    monkeypatch.setattr(rig.streams._allocator, "decide", counted)
    await rig.run(3.0)
    assert 6 <= len(decided) <= 12
    rig.streams.want(sound=True, picture=True, size="320x240", policy=None)
    assert decided[-1] == rig.clock.now_s()


async def test_room_is_made_once_for_each_try(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each trial of a dropped picture probes once, not repeatedly while it lasts."""
    rig = Rig()
    rig.begin()
    await rig.run(1.0)
    decide = rig.streams._allocator.decide
    made: list[float] = []
    monkeypatch.setattr(rig.congestion, "try_more", made.append)
    for tries, expected in ((False, 0), (True, 1), (True, 1), (False, 1), (True, 2)):

        def decides(*estimates: LinkEstimate, tries: bool = tries, **wanted: Any) -> Allocation:
            return replace(decide(*estimates, **wanted), tries=tries)

        monkeypatch.setattr(rig.streams._allocator, "decide", decides)
        await rig.run(0.3)
        assert len(made) == expected


async def test_a_picture_that_lost_its_thread_is_helped_when_there_is_room() -> None:
    """After a long closure one keyframe is requested, not one for each picture."""
    rig = Rig()
    rig.begin()
    await rig.run(3.0)
    rig.lane._shed()
    rig.lane._cut_layer = 0
    rig.asked.clear()
    await rig.run(1.5)
    assert 1 <= len(rig.asked) <= 2
    assert not rig.lane.is_cut


async def test_the_page_is_told_what_it_gets_when_that_changes() -> None:
    """The page learns of changes at once and of figures once a second, but of no assumption."""
    rig = Rig()
    rig.begin()
    assert not rig.all(messages.Served)
    await rig.run(5.0)
    told = rig.all(messages.Served)
    assert told[-1].rendition == TOP
    assert told[-1].picture_hz == 30.0
    assert (told[-1].layers, told[-1].layers_made) == (3, 3)
    assert told[-1].reason == Sentence("sent.all")
    assert len(told) <= 9


async def test_the_picture_is_held_back_by_the_server_where_the_browser_takes_it() -> None:
    """If the browser supports it the packets carry the hold-back, and its buffer has no target."""
    rig = Rig()
    rig.begin()
    for _ in range(8):
        rig.report(sound_ms=120.0, picture_ms=40.0)
    assert rig.held_ms[0] == 0.0
    assert max(rig.held_ms) >= 70.0
    assert {one.picture_target_ms for one in rig.all(messages.Playout)} == {None}


async def test_the_page_holds_the_picture_back_where_its_browser_does_not() -> None:
    """Without the header extension the hold-back is the target of the browser's buffer."""
    rig = Rig(takes_playout_delay=False)
    rig.begin()
    for _ in range(8):
        rig.report(sound_ms=120.0, picture_ms=40.0)
    assert rig.all(messages.Playout)[-1].picture_target_ms >= 70.0


async def test_nothing_to_hold_back_is_zero() -> None:
    """While the sound is at most 80 ms late the operator's picture is shown at once."""
    rig = Rig()
    rig.begin()
    rig.streams.set_role(OPERATOR, drives=True)
    for _ in range(8):
        rig.report(sound_ms=85.0, picture_ms=10.0)
    assert set(rig.held_ms) == {0.0}


@pytest.mark.parametrize("how", ["asked", "role"])
async def test_the_policy_changes_without_a_black_picture(how: str) -> None:
    """A change of policy, wished or by role, keeps lanes and renditions."""
    rig = Rig()
    rig.begin()
    await rig.run(2.0)
    for _ in range(6):
        rig.report(sound_ms=160.0, picture_ms=60.0)
    lane, left = rig.lane, rig.left
    rig.asked.clear()
    if how == "asked":
        rig.streams.want(sound=True, picture=True, size="640x480", policy="video-first")
    else:
        rig.streams.set_role(SyncSettings(policy="video-first"), drives=False)
    assert rig.all(messages.Playout)[-1].policy == "video-first"
    assert rig.held_ms[-1] == 0.0
    await rig.run(1.0)
    assert rig.lane is lane
    assert rig.left > left + 15
    assert not rig.asked


async def test_a_wish_for_another_policy_changes_no_size() -> None:
    """What is sent follows the link alone, however often a viewer changes the policy."""
    steady, fickle = Rig(), Rig()
    for rig in (steady, fickle):
        rig.begin()
        await rig.run(2.0)
    for second in range(10):
        other: Policy | None = "video-first" if second % 2 else None
        for rig, policy in ((steady, None), (fickle, other)):
            rig.streams.want(sound=True, picture=True, size="640x480", policy=policy)
            rig.rate_bps = 0.3e6 if second < 4 else 20e6
            await rig.run(1.0)
    assert fickle.sizes == steady.sizes


async def test_the_operator_may_have_a_rendition_of_their_own() -> None:
    """During their turn an operator may have a step between two others, which then disappears."""
    rig = Rig(rate_bps=0.75e6)
    shared = rig.video.names
    rig.video.start()
    try:
        rig.begin()
        rig.streams.set_role(OPERATOR.model_copy(update={"finer_ladder": True}), drives=True)
        await rig.run(6.0)
        assert rig.sizes[-1] not in shared
        assert rig.video.wanted == [rig.sizes[-1]]
        rig.streams.set_role(SyncSettings(), drives=False)
        await rig.run(2.0)
        assert rig.sizes[-1] in shared
        assert rig.video.names == shared
    finally:
        rig.video.stop()


async def test_a_wish_outlives_a_change_of_role() -> None:
    """A viewer's chosen policy stays during their turn, with the role's limits."""
    rig = Rig()
    rig.begin()
    rig.streams.want(sound=True, picture=True, size="640x480", policy="video-first")
    rig.streams.set_role(OPERATOR, drives=True)
    assert rig.all(messages.Playout)[-1].policy == "video-first"
    rig.streams.want(sound=True, picture=True, size="640x480", policy=None)
    assert rig.all(messages.Playout)[-1].policy == "audio-master"


async def test_a_fixed_media_unit_is_kept() -> None:
    """A configured media unit is not changed by the link."""
    rig = Rig()
    rig.begin()
    rig.streams.set_role(SyncSettings(audio_mu_ms=120), drives=False)
    await rig.run(1.0)
    assert rig.streams.status().entry["sound_mu_ms"] == 120


async def test_what_is_not_wanted_is_not_sent() -> None:
    """Without wanted streams the encoders pause; a chosen size limits what is sent."""
    rig = Rig()
    rig.begin()
    await rig.run(2.0)
    rig.streams.want(sound=True, picture=True, size="320x240", policy=None)
    await rig.run(2.0)
    assert all(name.startswith("320x240") for name in rig.video.wanted)
    rig.streams.want(sound=False, picture=False, size="320x240", policy=None)
    await rig.run(0.5)
    assert (rig.video.wanted, rig.audio.wanted) == ([], [])
    rig.streams.release()
    rig.streams.release()
