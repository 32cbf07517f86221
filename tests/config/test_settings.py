"""The configuration: what is refused, with which sentence; the examples."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config import settings as config
from wax.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Callable

CONFIG = Path(__file__).parents[2] / "config"
MANUAL = (CONFIG / "wax.toml").read_text(encoding="utf-8")


def _problems(text: str, tmp_path: Path) -> list[str]:
    """Load a file with this text; return the message's lines without its heading."""
    file = tmp_path / "robot.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as refused:
        config.load(file)
    heading, *problems = str(refused.value).splitlines()
    assert heading.startswith(f"{file}: {len(problems)} problem")
    return [problem.strip() for problem in problems]


@pytest.mark.parametrize("table", ["sync.operator", "sync.observer", "robot.serial", "video"])
def test_a_key_alone_leaves_the_others_as_they_are(table: str, tmp_path: Path) -> None:
    """If a file sets one key of a table, the others keep the defaults of that table."""
    defaults = tomllib.loads(MANUAL)
    for name in table.split("."):
        defaults = defaults[name]
    for name, value in defaults.items():
        if isinstance(value, str | int | float | bool):
            file = tmp_path / "robot.toml"
            written = str(value).lower() if isinstance(value, bool) else repr(value)
            file.write_text(f"[{table}]\n{name} = {written}\n", encoding="utf-8")
            assert config.load(file) == config.Settings()


@pytest.mark.parametrize(
    ("url", "names"),
    [
        ("", ["a.example"]),
        ("https://robot.example.org", ["a.example", "robot.example.org"]),
        ("http://[2001:db8::7]:8080", ["a.example", "2001:db8::7"]),
        ("https://example.org/robots/1", ["a.example", "example.org"]),
    ],
)
def test_the_public_page_is_one_of_the_names(url: str, names: list[str]) -> None:
    """The public URL's host counts as one of the server's names."""
    server = config.parse({"server": {"names": ["a.example"], "public_url": url}}, "x").server
    assert server.all_names == names


def test_sites_that_may_frame_the_page(tmp_path: Path) -> None:
    """Whole sites with or without a port are accepted; by http only this machine."""
    file = tmp_path / "robot.toml"
    sites = ["https://Museum.example", "https://a-b.example:8443", "http://localhost:3000"]
    sites += ["http://127.0.0.1", "http://site.localhost:80"]
    file.write_text(f"[page]\nembed_on = {sites}", encoding="utf-8")
    kept = [one.lower().removesuffix(":80") for one in sites]
    assert config.load(file).page.embed_on == kept


def test_public_robot_is_a_valid_example() -> None:
    """The example for a public robot loads, is reachable, dated and slower than the default."""
    settings = config.load(CONFIG / "public-robot.toml")
    assert settings.server.host == "0.0.0.0"
    assert settings.video.timestamp_overlay
    assert settings.robot.max_linear_mps < config.Settings().robot.max_linear_mps


def test_the_wheelchair_is_a_valid_example() -> None:
    """The wheelchair example has a person aboard, soft braking, and operators who must answer."""
    settings = config.load(CONFIG / "nepwak.toml")
    assert settings.local.is_on
    assert settings.local.script
    assert settings.robot.soft_braking
    assert settings.turns.ready_s > 0
    assert not config.Settings().local.is_on


def test_the_mecanum_robot_is_a_valid_example() -> None:
    """The example moves sideways, slower than ahead; by default a robot does not."""
    robot = config.load(CONFIG / "mecanum.toml").robot
    assert 0 < robot.lateral_mps < robot.max_linear_mps
    assert config.Settings().robot.lateral_mps == 0


def test_a_script_must_end_before_it_begins_again(tmp_path: Path) -> None:
    """An act after the end of the script is refused."""
    text = "[local]\nscript_s = 10.0\nscript = [{ at_s = 9.0, for_s = 1.0 }]\n"
    (problem,) = _problems(text, tmp_path)
    assert problem == ("local: the act at 9 s ends after script_s, 10 s; make script_s longer")


def test_the_hand_control_has_a_line_of_its_own(tmp_path: Path) -> None:
    """The hand control and the robot may not share a port: each would get half of the bytes."""
    serial = '[robot]\ndriver = "serial"\n[robot.serial]\nurl = "/dev/ttyACM1"\n'
    (problem,) = _problems(serial + '[local]\nsource = "serial"\n', tmp_path)
    assert "both /dev/ttyACM1; the hand control needs a line of its own" in problem


def test_the_baseline_is_the_thesis() -> None:
    """The file sets every constant of the thesis; everybody queues, and each picture is dated."""
    tree = tomllib.loads((CONFIG / "thesis.toml").read_text(encoding="utf-8"))
    assert set(tree["thesis"]) == set(config.Settings().thesis.model_dump())
    settings = config.load(CONFIG / "thesis.toml")
    assert settings.sync.policy == "thesis"
    assert settings.turns.join == "auto"
    assert settings.video.timestamp_overlay
    assert settings.thesis == config.Settings().thesis


def test_the_built_in_player_is_known_by_its_former_name() -> None:
    """The built-in player's name of before version 0.9 is accepted."""
    role = config.parse({"sync": {"observer": {"player": "own"}}}, "shown").sync.observer
    assert role.player == "built-in"


def test_all_problems_are_told_at_once(tmp_path: Path) -> None:
    """Unknown keys, wrong types and values out of range are one line each, in one message."""
    text = """
    [server]
    port = 99999
    hots = "x"
    [video]
    fps = "many"
    width = 33
    codec = "av1"
    [sync.operator]
    audio_delay_ms = 5
    """
    assert sorted(_problems(text, tmp_path)) == [
        "server.hots: there is no such key; did you mean host?",
        "server.port: got 99999; allowed is a whole number from 0 to 65535",
        'sync.operator.audio_delay_ms: got 5; allowed is "auto" or a number from 20 to 500',
        'video.codec: got "av1"; allowed is "vp8" or "h264"',
        'video.fps: got "many"; allowed is a number from 1 to 240',
        'video.width: got 33; allowed is an even number from 32 to 3840 or "auto"',
    ]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("speed = 1", "speed: there is no such key"),
        ("[lidar]", "lidar: there is no such key"),
        ("turns = 5", "turns: got 5; allowed is a table"),
        ("[turns]\nturn_s = nan", "turns.turn_s: got nan; allowed is a number from 1 to 86400"),
        ("[turns]\nturn_s = inf", "turns.turn_s: got inf; allowed is a number from 1 to 86400"),
        ("[turns]\nturn_s = true", "turns.turn_s: got true; allowed is a number from 1 to 86400"),
        (
            "[turns]\nturn_s = 2026-01-01",
            'turns.turn_s: got "2026-01-01"; allowed is a number from 1 to 86400',
        ),
        (
            "[server]\nport = 80.5",
            "server.port: got 80.5; allowed is a whole number from 0 to 65535",
        ),
        ("[server]\nhost = ''", 'server.host: got ""; allowed is a text that is not empty'),
        (
            "[drive]\nslow_fraction = 0",
            "drive.slow_fraction: got 0; allowed is a number above 0, at most 1",
        ),
        (
            "[thesis]\naudio_mu_ms = 250",
            "thesis.audio_mu_ms: got 250; allowed is "
            "100 to 500, a whole multiple of video_mu_ms (thesis 3.3.3) and of 20",
        ),
        (
            "[thesis]\nvideo_mu_ms = 80",
            "thesis.audio_mu_ms: 500 is no whole multiple of video_mu_ms, which is 80",
        ),
        (
            "[video]\ntimestamp_overlay = 1",
            "video.timestamp_overlay: got 1; allowed is true or false",
        ),
        ("[video]\nimprint = true", "video.imprint: is now called video.timestamp_overlay"),
        ("[audio]\nforms = []", "audio.forms: is now called audio.encodings"),
        ("[drive]\nfine_fraction = 0.5", "drive.fine_fraction: is now called drive.slow_fraction"),
        (
            "[sync.observer]\nown_rendition = true",
            "sync.observer.own_rendition: is now called sync.observer.finer_ladder",
        ),
        (
            "[video]\nrenditions = []",
            'video.renditions: got []; allowed is a list of tables, 1 to 8 of them, or "auto"',
        ),
        ("[video]\nrenditions = [5]", "video.renditions[0]: got 5; allowed is a table"),
        (
            "[[video.renditions]]\nwidth = 64\nheight = 48\nfps = 5",
            "video.renditions[0].bitrate_bps: is missing; "
            "allowed is a whole number from 10000 to 20000000",
        ),
        (
            "[[ice.servers]]\nurls = 'turn:x'",
            "ice: is gone, since its passwords were shown to every visitor; list STUN servers in "
            "network.stun, and name a TURN server with its static-auth-secret in [relay]",
        ),
        *[
            (
                f"{table}\nretry_s = 2.0",
                f"{key}.retry_s: is gone; delete it: "
                "what has failed is opened again after a second",
            )
            for table, key in (("[voice]", "voice"), ("[[camera]]\nname = 'Arm'", "camera[0]"))
        ],
        (
            "[network]\nstun = ['http://x']",
            'network.stun[0]: got "http://x"; allowed is an address as "stun:HOST:PORT"',
        ),
        (
            "[network]\npublic_addresses = ['robot.example']",
            'network.public_addresses[0]: got "robot.example"; allowed is an IPv4 or IPv6 address',
        ),
        (
            "[network]\npublic_addresses = ['203.0.113']",
            "network.public_addresses: 203.0.113 is no address; "
            "write it as 203.0.113.7 or 2001:db8::7",
        ),
        (
            "[server]\nnames = ['☃.example']",
            "server.names[0]: '☃.example' is no host name (Codepoint U+2603 at position 1 of '☃'"
            " not allowed); if browsers know it, write it as they send it, which begins with"
            ' "xn--"',
        ),
        *[
            (
                f"[server]\npublic_url = '{url}'",
                f'server.public_url: got "{url}"; allowed is '
                'empty, or an address as "https://robot.example.org", without "/" at its end',
            )
            for url in ("robot.example.org", "https://robot.example.org/", "ftp://a", "http://a:b")
        ],
        *[
            (f"[page]\n{key} = {value}", f"page.{key}: got {shown}; allowed is {allowed}")
            for key, value, shown, allowed in [
                ("name", "''", '""', "a text of 1 to 40 printable characters"),
                ("name", '"a\\nb"', '"a\\nb"', "a text of 1 to 40 printable characters"),
                ("accent", "'green'", '"green"', 'empty, or a colour as "#0b6b4c"'),
                ("accent", "'#0b6b4'", '"#0b6b4"', 'empty, or a colour as "#0b6b4c"'),
                (
                    "rules",
                    "['a', 'b', 'c', 'd', 'e', 'f', 'g']",
                    '["a", "b", "c", "d", "e", "f", "g"]',
                    "a list of sentences, 0 to 6 of them",
                ),
            ]
        ],
        *[
            (
                f"[[page.links]]\ntext = 'Us'\nurl = '{url}'",
                f'page.links[0].url: got "{url}"; allowed is '
                'an address as "https://example.org/us" or "mailto:us@example.org"',
            )
            for url in (
                "javascript:alert(1)",
                "data:text/html,hi",
                "//example.org",
                "https:///x",
                "mailto:us",
                "https://exa mple.org",
            )
        ],
        (
            "[page]\nembed_on = ['https://me:pw@museum.example/*']",
            'page.embed_on[0]: "https://…@museum.example/*" has a user\'s name;'
            " leave out all before the @",
        ),
        *[
            (
                f"[[publish]]\n{key} = '{example.replace('//', '//me:pw@')}/a@b'",
                f'publish[0].{key}: got "{example.partition("//")[0]}//…@b"; allowed is an address'
                f' as "{example}", without a user\'s name',
            )
            for key, example in (
                ("livekit", "wss://livekit.example.org"),
                ("whip", "https://media.example.org"),
                ("watch", "https://media.example.org"),
            )
        ],
        *[
            (f"[page]\nembed_on = ['{site}']", f"page.embed_on[0]: '{site}' {sentence}")
            for site, sentence in [
                ("https://*.example", "has a wildcard; list each site by its name"),
                ("*", "has a wildcard; list each site by its name"),
                (
                    "https://museum.example/robots",
                    "has a path; write the whole site, 'https://museum.example'",
                ),
                (
                    "https://museum.example/",
                    "has a path; write the whole site, 'https://museum.example'",
                ),
                (
                    "http://museum.example",
                    "can be forged on its way; name a site with https, or localhost",
                ),
                (
                    "http://localhost.example",
                    "can be forged on its way; name a site with https, or localhost",
                ),
                (
                    "https://museum.example:99999",
                    "has no valid port; leave it out, or correct it",
                ),
                *[
                    (text, 'is no site; one is "https://museum.example"')
                    for text in (
                        "",
                        "museum.example",
                        "ftp://museum.example",
                        "https://a.example https://b.example",
                        "https://a.example; script-src x",
                        "https://[2001:db8::7]",
                    )
                ],
            ]
        ],
        (
            "[relay]\nurls = ['turn:x']",
            "relay: there are urls without a secret; name the file that holds the TURN server's "
            "static-auth-secret in secret_file",
        ),
        (
            "[relay]\nurls = ['turn:x']\nsecret = 'a'\nsecret_file = 'b'",
            "relay: there are a secret and a secret_file; leave one of them out",
        ),
        (
            "[relay]\nonly = true",
            "relay: only = true needs urls, the addresses of a TURN server",
        ),
        (
            "[robot.serial]\naxes = ['a', 'b', 'c', 'd', 'e']",
            'robot.serial.axes: got ["a", "b", "c", "d", "e"]; '
            "allowed is a list of names, 0 to 4 of them",
        ),
        *[
            (
                f"[robot.serial]\naxes = ['pan', {name}]",
                f"robot.serial.axes[1]: got {shown}; allowed is "
                "a name of at most 16 letters, digits and _, not beginning with a digit",
            )
            for name, shown in [
                ("''", '""'),
                ("'2nd'", '"2nd"'),
                ("'a b'", '"a b"'),
                ('"tilt\\n"', '"tilt\\n"'),
                ("'seventeen_letters'", '"seventeen_letters"'),
                ("5", "5"),
            ]
        ],
        (
            "[robot.serial]\naxes = ['pan', 'pan']",
            "robot.serial.axes: two axes have the name pan; give each its own",
        ),
        *[
            (f"[video]\n{keys}", f"video: {sentence}")
            for keys, sentence in [
                (
                    "camera_height_m = 0.3",
                    "camera_height_m and camera_fov_deg belong together; camera_fov_deg is missing",
                ),
                (
                    "camera_fov_deg = 70.0",
                    "camera_height_m and camera_fov_deg belong together; "
                    "camera_height_m is missing",
                ),
                (
                    "camera_height_m = 0.3\ncamera_fov_deg = 5.0",
                    "camera_fov_deg is 5; no camera sees less than 10 degrees across, "
                    "or 0 if it is not known",
                ),
                (
                    "camera_height_m = 0.01\ncamera_fov_deg = 70.0",
                    "camera_height_m is 0.01; a camera that sees the floor is at least 0.02 m "
                    "above it, or 0 if its height is not known",
                ),
            ]
        ],
        (
            "[robot.serial.bytes]\nfine = 700",
            "robot.serial.bytes.fine: got 700; "
            'allowed is a whole number from 0 to 255, or "none" to send nothing',
        ),
        (
            f"[server]\nhost = [{'1,' * 100}]",
            "server.host: got [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1…; "
            "allowed is a text that is not empty",
        ),
    ],
)
def test_a_problem_is_one_sentence(text: str, problem: str, tmp_path: Path) -> None:
    """A problem names the key, what it got and what is allowed."""
    assert _problems(text, tmp_path) == [problem]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "[video]\nrenditions = ["
            "{ width = 64, height = 48, fps = 5.0, bitrate_bps = 50000 },"
            "{ width = 96, height = 48, fps = 5.0, bitrate_bps = 50000 }]",
            "video.renditions: 96x48 at 50 kbit/s follows 64x48 at 50 kbit/s; "
            "put the one of the higher bit rate first",
        ),
        (
            "[audio]\nencodings = ["
            "{ mu_ms = 40, bitrate_bps = 24000 }, { mu_ms = 20, bitrate_bps = 16000 }]",
            "audio.encodings: the encoding of 20 ms follows that of 40 ms; "
            "media units must grow and bit rates fall from one to the next",
        ),
        (
            "[audio]\nencodings = ["
            "{ mu_ms = 20, bitrate_bps = 24000, stereo_bitrate_bps = 32000 },"
            "{ mu_ms = 40, bitrate_bps = 24000, stereo_bitrate_bps = 40000 }]",
            "audio.encodings: the encoding of 40 ms follows that of 20 ms; "
            "media units must grow and bit rates fall from one to the next",
        ),
        (
            "[[audio.encodings]]\nmu_ms = 20\nbitrate_bps = 32000\nstereo_bitrate_bps = 24000",
            "audio.encodings[0]: stereo_bitrate_bps of the encoding of 20 ms is below its"
            " bitrate_bps; two channels take more than one, or 0 for none",
        ),
    ],
)
def test_a_ladder_that_does_not_go_down_is_refused(text: str, problem: str, tmp_path: Path) -> None:
    """Each step down the ladder must cost less, so the order is checked."""
    assert _problems(text, tmp_path) == [problem]


def test_an_automatic_size_is_one_that_is_left_out(tmp_path: Path) -> None:
    """The word "auto" is as good as no key; half a size is refused, with the key to add."""
    keys = ("width", "height", "renditions")
    said = config.parse({"video": dict.fromkeys(keys, "auto")}, "robot.toml").video
    assert (said.has_auto_size, said.has_auto_ladder, said) == (True, True, config.Settings().video)
    assert _problems("[video]\nwidth = 320", tmp_path) == [
        "video: width and height belong together; height is missing"
    ]
    text = '[video]\nwidth = "auto"\nheight = 240'
    assert "width is missing" in _problems(text, tmp_path)[0]


def test_a_ladder_follows_from_the_size() -> None:
    """A configured size has a ladder of its own shape."""
    video = config.parse({"video": {"width": 1920, "height": 1080}}, "robot.toml").video
    assert [one.size for one in video.renditions][:3] == ["1920x1080", "1280x720", "960x540"]


def test_one_size_may_have_several_rates(tmp_path: Path) -> None:
    """Several renditions may have one size: a viewer chooses the size, their link the bitrate."""
    size = "width = 64, height = 48, fps = 5.0"
    file = tmp_path / "robot.toml"
    file.write_text(
        f"[video]\nrenditions = [{{ {size}, bitrate_bps = 90000 }},"
        f" {{ {size}, bitrate_bps = 50000 }}]",
        encoding="utf-8",
    )
    assert [one.size for one in config.load(file).video.renditions] == ["64x48", "64x48"]


def test_a_speed_byte_can_be_left_out(tmp_path: Path) -> None:
    """A speed byte may be "none", for boards without speeds."""
    file = tmp_path / "robot.toml"
    file.write_text('[robot.serial.bytes]\nfine = "none"\ngross = "none"\n', encoding="utf-8")
    dialect = config.load(file).robot.serial.bytes
    assert dialect.fine is None
    assert dialect.gross is None


@pytest.mark.parametrize(
    ("text", "lateral_mps"),
    [
        ("", 0.0),
        ("base = 'mecanum'", 0.4),
        ("base = 'omni'", 0.4),
        ("base = 'omni'\nmax_lateral_mps = 0", 0.0),
        ("max_lateral_mps = 0.3", 0.3),
        ("base = 'mecanum'\nmax_lateral_mps = 0.2", 0.2),
    ],
)
def test_how_fast_a_base_moves_sideways(text: str, lateral_mps: float, tmp_path: Path) -> None:
    """By itself a base is as fast sideways as ahead, or cannot; a number is taken as it is."""
    file = tmp_path / "robot.toml"
    file.write_text(f"[robot]\nmax_linear_mps = 0.4\n{text}\n", encoding="utf-8")
    assert config.load(file).robot.lateral_mps == lateral_mps


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda file: file.unlink(missing_ok=True), "cannot be read: No such file or directory"),
        (lambda file: file.mkdir(), "cannot be read: it is a folder"),
        (lambda file: file.write_bytes(b"\xff\xd8\xff\xe0"), "is not UTF-8 text"),
        (lambda file: file.write_text("[server"), "is not valid TOML: "),
        (lambda file: file.write_text("a = 1\na = 2"), "is not valid TOML: "),
        (lambda file: file.write_text(f"a = 1{'0' * 5000}"), "is not valid TOML: "),
        (lambda file: file.write_text(f"a = {'[' * 5000}"), "is not valid TOML: "),
        (lambda file: file.write_text(f"a = {'[' * 17}{']' * 17}"), "is nested more than 16 "),
        (lambda file: file.write_text(f"video.source{'.a' * 15} = 1"), "is nested more than 16 "),
        (lambda file: file.write_text(f"[video.source{'.a' * 2000}]"), "is nested more than 16 "),
    ],
)
def test_a_file_that_is_none_is_refused(
    make: Callable[[Path], object], sentence: str, tmp_path: Path
) -> None:
    """An unreadable file is refused with its name and the reason."""
    file = tmp_path / "robot.toml"
    make(file)
    with pytest.raises(ConfigError) as refused:
        config.load(file)
    assert str(refused.value).startswith(f"{file}: {sentence}")


def test_an_editor_of_windows_is_no_problem(tmp_path: Path) -> None:
    """A byte order mark and carriage returns are accepted."""
    file = tmp_path / "robot.toml"
    file.write_bytes(b"\xef\xbb\xbf[server]\r\nport = 9000\r\n")
    assert config.load(file).server.port == 9000


_LEAVES: st.SearchStrategy[Any] = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.dates() | st.just({})
)


@given(
    st.recursive(
        _LEAVES,
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(
                    ["server", "video", "renditions", "robot", "serial", "sync", "operator", "port"]
                )
                | st.text(max_size=5),
                inner,
                max_size=4,
            )
        ),
    ).filter(lambda tree: isinstance(tree, dict))
)
def test_no_tree_is_too_strange(tree: dict[str, Any]) -> None:
    """Any tree is accepted, or refused with a line for each problem."""
    try:
        config.parse(tree, "robot.toml")
    except ConfigError as error:
        heading, *lines = str(error).splitlines()
        assert heading.startswith("robot.toml: ")
        assert lines


@pytest.mark.parametrize(
    "tree",
    [
        {"max_age_ms": 600.0},
        {"max_command_age_ms": 100.0},
        {"slow_picture_age_ms": 900.0},
        {"stop_picture_age_ms": 300.0},
    ],
)
def test_limits_of_driving_that_contradict_each_other(tree: dict[str, float]) -> None:
    """A limit that could never be reached is refused with both numbers and what to do."""
    with pytest.raises(ConfigError, match=r"drive: .* be the larger one"):
        config.parse({"drive": tree}, "wax.toml")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('[[camera]]\nsource = "testcard"\n', "camera[0].name: is missing"),
        ('[[camera]]\nname = "A"\nsource = "none"\n', "leave its table out"),
        ('[[camera]]\nname = "A"\n[[camera]]\nname = "A"\n', "two have the name A"),
        (
            '[[camera]]\nname = "A"\naxes = ["pan"]\n[[camera]]\nname = "B"\naxes = ["pan"]\n',
            "two move with the axis pan",
        ),
        ('[video]\nsource = "none"\n[[camera]]\nname = "A"\n', "no driving view beside"),
        ('[sync]\npolicy = "thesis"\n[[camera]]\nname = "A"\n', "showed one picture"),
        ("".join(f'[[camera]]\nname = "{n}"\n' for n in range(5)), "0 to 4 of them"),
        ('[[camera]]\nname = "A\\nB"\n', "a text of 1 to 24 printable characters"),
    ],
)
def test_cameras_beside_the_driving_view(text: str, says: str, tmp_path: Path) -> None:
    """Further cameras need unique names and a driving view; each problem begins with a key."""
    (problem,) = _problems(text, tmp_path)
    assert says in problem
    assert problem[0].isalpha()
