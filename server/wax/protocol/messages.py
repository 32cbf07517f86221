"""The messages between page and server.

The page opens two data channels: ``drive`` (unordered, no retransmits) carries what is worthless
when late, ``state`` (reliable, ordered) the rest. Messages on ``state`` are JSON objects with a
``type``; on ``drive``, which must fit through a modem twenty times a second, they are arrays
(`wax.protocol.compact`). Times named ``…server_ms`` are on the server's monotonic clock.
"""

from __future__ import annotations

from operator import not_
from typing import Annotated, Final, Literal, get_args

from pydantic import ConfigDict, Field, TypeAdapter

from wax.protocol import compact, foreign_json
from wax.protocol.host_switches import HostSettings, SwitchAct
from wax.protocol.model import Incoming, Outgoing
from wax.protocol.robot_report import RobotReport
from wax.sentence import Sentence

MAX_DRIVE_BYTES = 256
MAX_STATE_BYTES = 2048
MAX_NAME_CHARS = 24
MAX_TASK_CHARS = 100

Ms = Annotated[float, Field(ge=-1e15, le=1e15)]
Counter = Annotated[int, Field(ge=0, le=2**53)]
Unit = Annotated[float, Field(ge=-1, le=1)]
Role = Literal["operator", "queued", "observer"]
Speed = Literal["slow", "fast"]
HeardBeat = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{6}$")] | None
"""The newest beat that the page has received (`wax.control.beats`), null before the first."""


# --- drive channel, page → server ---------------------------------------------------------


class Drive(Incoming):
    """A complete set-point from the operator's input."""

    type: Literal["drive"]
    seq: Counter
    turn: Counter
    sent_server_ms: Ms
    linear: Unit
    """A fraction of the robot's limit; ahead is positive."""
    angular: Unit
    """A fraction of the robot's limit; left is positive."""
    held: bool
    """The dead man's switch: some control is held down. Without it, nothing moves."""
    speed: Speed
    seen_server_ms: Ms | None
    """Capture time of the newest picture on screen, null if unknown."""
    axes: Annotated[dict[Annotated[str, Field(max_length=16)], Unit], Field(max_length=4)] = {}
    """Positions of the axes being held; the others keep theirs."""
    beat: HeardBeat
    """Proves `sent_server_ms`."""
    lateral: Unit = 0.0
    """A fraction of the robot's limit sideways; left is positive. Absent where it has none."""


ControlName = Annotated[str, Field(max_length=16)]
ControlNumber = Annotated[float, Field(ge=-10_000, le=10_000)]


class Operate(Incoming):
    """The robot's controls that this page holds, and those that it sets, by name.

    A held button or a toggle that is on is 1, a toggle that is off 0; a slider has its own value, a
    choice its index. It is repeated while anything is held, and until `Operated` confirms that
    `wanted` has arrived. `turn` is the operator's turn; others may send any number.
    """

    type: Literal["operate"]
    seq: Counter
    turn: Counter
    sent_server_ms: Ms
    held: Annotated[dict[ControlName, ControlNumber], Field(max_length=4)]
    wanted: Annotated[dict[ControlName, ControlNumber], Field(max_length=2)]
    beat: HeardBeat


class Ping(Incoming):
    """The page's heartbeat, and one half of the clock alignment.

    `sent_page_ms` is the page's own clock, returned in the pong. `pong_id` is the newest pong
    received and `pong_held_ms` how long ago, from which the server learns the round trip.
    """

    type: Literal["ping"]
    id: Counter
    sent_page_ms: Ms
    pong_id: Counter | None
    pong_held_ms: Ms | None


class SoundReport(Incoming):
    """How the sound plays; null where the browser does not report it."""

    age_ms: Ms | None
    """From capture to the ear."""
    delay_ms: Ms | None
    """The part of the age in the jitter buffer."""
    output_ms: Ms | None
    """The part of the age in the device (webrtc-stats, `media-playout`; large for Bluetooth)."""
    concealed_ms: Ms | None
    """A total since the start of this peer, as are the next two."""
    played_ms: Ms | None
    stretched_ms: Ms | None
    """Sound that was played slowly, to wait for more."""
    player: Literal["browser", "built-in"]
    """The player that these figures are of; the page's built-in player sets its own delay."""


class PictureReport(Incoming):
    """How the picture plays; null where the browser does not report it.

    `age_ms` is from capture to the screen, `delay_ms` the part of it in the jitter buffer,
    `rate_hz` the pictures shown in the last second. `frozen_ms` counts from the start of this peer.
    """

    age_ms: Ms | None
    delay_ms: Ms | None
    rate_hz: Annotated[float, Field(ge=0, le=1e6)] | None
    frozen_ms: Ms | None


class Report(Incoming):
    """The page's measurements, a few times a second; a stream that is off is null.

    `clock_error_ms` is the largest possible error of the ages.
    """

    type: Literal["report"]
    sound: SoundReport | None
    picture: PictureReport | None
    clock_error_ms: Ms | None


# --- state channel, page → server ---------------------------------------------------------


class SetName(Incoming):
    """The name that others see; trimmed and cut by the server."""

    type: Literal["name"]
    name: Annotated[str, Field(max_length=200)]


class Join(Incoming):
    """Join the end of the queue."""

    type: Literal["join"]


class Leave(Incoming):
    """Leave the queue, or end your turn."""

    type: Literal["leave"]


class Here(Incoming):
    """Answer to a call: this viewer is present and wants their turn."""

    type: Literal["here"]


class Stop(Incoming):
    """Stop the robot now, until the stop is released.

    A retry, for want of an answer, has the `press` of the first attempt.
    """

    type: Literal["stop"]
    press: Counter | None = None


class Release(Incoming):
    """Release the stop with this number, which moves nothing by itself.

    A late release, or one for an earlier stop, has no effect.
    """

    type: Literal["release"]
    stop: Counter
    sent_server_ms: Ms
    beat: HeardBeat


class Want(Incoming):
    """Which streams this viewer wants and the largest picture; unknown sizes are refused.

    A null `policy` means the role's default.
    """

    type: Literal["want"]
    sound: bool
    picture: bool
    size: Annotated[str, Field(max_length=16)]
    policy: Literal["audio-master", "video-first"] | None


class Look(Incoming):
    """Which camera other than the driving view this page shows large, null for none of them.

    It is an index into `Hello.cameras`. `small` says whether the page shows the others small.
    """

    type: Literal["look"]
    large: Annotated[int, Field(ge=0, lt=16)] | None
    small: bool


class KeepTape(Incoming):
    """Keep what was recorded in the last two minutes."""

    type: Literal["keep_tape"]


class SetTask(Incoming):
    """What the operator of the turn with this number does; trimmed and cut by the server."""

    type: Literal["task"]
    turn: Counter
    text: Annotated[str, Field(max_length=400)]


class Disown(Incoming):
    """Do not use the recording of the turn with this number, which this viewer has just driven."""

    type: Literal["disown"]
    turn: Counter


class Follow(Incoming):
    """Send this viewer `Driven` from now on, for a program that watches how people drive."""

    type: Literal["follow"]


class Received(Incoming):
    """The last packet of a media unit has arrived; `rtp` is its RTP time.

    Sent only if `Hello` asks for it: for each picture, and for the sound as `Units` defines.
    """

    type: Literal["received"]
    kind: Literal["audio", "video"]
    rtp: Annotated[int, Field(ge=0, lt=2**32)]


# --- state channel, the host's page → server; the switches are in host_switches.py ---------


class EndTurn(Incoming):
    """End the turn with this number; a late request ends no other."""

    type: Literal["end_turn"]
    turn: Counter


class Remove(Incoming):
    """Close a viewer's pages; with `ban` also keep out this browser and address for a day."""

    type: Literal["remove"]
    viewer: Counter
    ban: bool


class Mute(Incoming):
    """Ignore a viewer's Stop, or obey it again."""

    type: Literal["mute"]
    viewer: Counter
    muted: bool


class MuteAddress(Incoming):
    """Ignore the Stop of everybody at an address, one of `Console.pressers`, or obey it again."""

    type: Literal["mute_address"]
    presser: Counter
    muted: bool


class SignOutOthers(Incoming):
    """Sign out all other hosts, who become guests, and void all unused host links."""

    type: Literal["sign_out_others"]


class Announce(Incoming):
    """Show everybody a sentence; an empty one removes it, and it expires after `for_s`."""

    type: Literal["announce"]
    text: Annotated[str, Field(max_length=200)]
    for_s: Annotated[int, Field(ge=1, le=604_800)] | None = None


class Invite(Incoming):
    """Ask for an invitation, which `uses` people can use within `valid_s` seconds."""

    type: Literal["invite"]
    purpose: Literal["watch", "queue"]
    uses: Annotated[int, Field(ge=1, le=1000)]
    valid_s: Annotated[int, Field(ge=60, le=31_536_000)]


# --- server → page ------------------------------------------------------------------------


class Pong(Outgoing):
    """Answer to a ping, on the drive channel; also a beat."""

    type: Literal["pong"] = "pong"
    id: int
    sent_page_ms: float
    server_ms: float
    beat: str


class Beat(Outgoing):
    """A beat between pongs for a page that sends commands, on the drive channel."""

    type: Literal["beat"] = "beat"
    beat: str


class Operated(Outgoing):
    """Confirms, on the drive channel, that the `Operate` with this number has arrived.

    `refused` is a sentence that says why it has no effect, null if it has one. A late `Operate`
    gets no answer, and the page sends it again.
    """

    type: Literal["operated"] = "operated"
    seq: int
    refused: Sentence | None


class CameraGeometry(Outgoing):
    """How the driving view's camera sees the floor while no axis turns it.

    It is above the robot's middle, tilted down by `tilt_deg`, and sees `fov_deg` from left to
    right. `axis_row` is the height of its optical axis, as a fraction of the picture's height.
    """

    height_m: float
    tilt_deg: float
    fov_deg: float
    axis_row: float


class MotionInfo(Outgoing):
    """How the robot follows commands, to predict its path.

    It accelerates at the two accelerations, and brakes at `braking_mps2`.
    """

    acceleration_mps2: float
    acceleration_rps2: float
    braking_mps2: float


class RobotInfo(Outgoing):
    """The robot's abilities, sent at connect.

    `camera` is null if its geometry is not configured, `width_m` if the robot's width is unknown.
    """

    kind: str
    max_linear_mps: float
    max_angular_rps: float
    max_lateral_mps: Annotated[float, Field(exclude_if=not_)] = 0.0
    """Sideways; absent for a robot that cannot."""
    slow_fraction: float
    axes: list[str]
    motion: MotionInfo
    camera: CameraGeometry | None
    camera_stereo: Annotated[bool, Field(exclude_if=not_)] = False
    """Whether its picture is a stereo pair side by side; absent if not."""
    width_m: float | None


class PageLink(Outgoing):
    """One of the host's links."""

    text: str
    url: str


class PageInfo(Outgoing):
    """The host's branding, of which each field is a key of `[page]`.

    An empty `sentence` means the page's default.
    """

    name: str
    sentence: str = ""
    rules: list[str] = []
    links: list[PageLink] = []


class LossRules(Outgoing):
    """What the robot does when something fails: sent at connect, not negotiable."""

    max_age_ms: float
    """A command is valid for this long, plus the link's own delay."""
    max_command_age_ms: float
    """The maximum of both together."""
    slow_picture_age_ms: float
    """A picture older than this, plus the link's own delay, slows the robot."""
    stop_picture_age_ms: float
    """A picture older than this, plus the link's own delay, stops the robot."""
    resume_within_ms: float
    """After an interruption shorter than this, a control that is still held drives on."""
    lost_after_ms: float
    """An operator silent for this long is lost; their turn is kept for `Hello.grace_s`."""
    max_stop_distance_m: float
    silence_ms: float | None
    """The driver's process stops the robot after this long without the server; null where the
    server itself runs the driver."""
    robot_ttl_ms: float | None
    """The robot stops by itself after this long; null if it has no known watchdog."""
    soft_braking: bool
    """Whether the robot brakes at `braking_mps2` when a control is released or interrupted."""
    stop_by: Literal["everybody", "operator"]


class VoiceRules(Outgoing):
    """How people speak through the robot, if they are permitted to.

    With `open_microphone`, they need not hold anything while they speak.
    """

    open_microphone: bool


class CameraInfo(Outgoing):
    """A camera other than the driving view, and the robot's axes that turn it."""

    name: str
    axes: list[str]


class ControlInfo(Outgoing):
    """A control of the robot besides its wheels, of which each field is a key of `[[controls]]`.

    `min`, `max` and `step` are a slider's.
    """

    name: str
    label: str
    kind: Literal["button", "toggle", "slider", "choice"]
    min: float
    max: float
    step: float
    choices: list[str]
    key: str
    """The key that presses it, by its position on the keyboard; empty for none."""
    pad_button: str
    """The button of a standard gamepad that presses it, by its label on an Xbox's; may be empty."""
    moves: bool
    """Whether using it counts as driving."""
    roles: list[Literal["operator", "host", "observer"]]
    """Who may use it."""


class GaugeInfo(Outgoing):
    """A number that the robot reports, of which each field is a key of `[[gauges]]`."""

    name: str
    label: str
    unit: str
    min: float
    max: float
    decimals: int


class Hello(Outgoing):
    """The first message on the state channel."""

    type: Literal["hello"] = "hello"
    version: str
    viewer: int
    page: PageInfo
    robot: RobotInfo
    sizes: list[str]
    turn_s: float
    grace_s: float
    command_rate_hz: float
    click_to_move: bool
    """Whether a click may hold a direction for two seconds."""
    on_loss: LossRules
    is_host: bool
    """Whether this page has shown the host's secret."""
    has_microphone: bool
    """False where the host has configured no sound."""
    may_hear: bool
    """False for strangers where the host lets only invited people hear."""
    may_queue: bool
    """False for strangers where the host lets only invited people drive."""
    acknowledge: bool
    """Whether the page must send `Received`."""
    voice: VoiceRules | None = None
    """Null where nobody can speak through the robot."""
    cameras: list[CameraInfo] = []
    """The cameras other than the driving view."""
    controls: list[ControlInfo] = []
    gauges: list[GaugeInfo] = []


class ViewerInfo(Outgoing):
    """One viewer. `place` is 0 for the operator, 1… for the queue, otherwise null.

    `wait_s` is the longest time until their turn, null if unknown. `host` marks the host's own
    pages.
    """

    id: int
    name: str
    role: Role = "observer"
    place: int | None = None
    wait_s: float | None = None
    lost: bool = False
    host: bool = False


class TurnInfo(Outgoing):
    """The current turn; `ends_server_ms` is null only when nobody drives.

    While something other than the operator prevents driving, the turn's clock is paused with
    `stands_left_ms` left; the turn still ends at `ends_server_ms` at the latest. `axes` are the
    positions at its start of the axes that have moved since the robot connected.
    """

    number: int
    operator: int | None = None
    ends_server_ms: float | None = None
    stands_left_ms: float | None = None
    axes: dict[str, float] = {}


class CallInfo(Outgoing):
    """The next in the queue has until then to answer that they are present."""

    viewer: int
    until_server_ms: float


class RobotStatus(RobotReport, Outgoing):
    """The robot; `problem` is a sentence, null if there is none.

    `gauges` are those of `Hello` that the robot reports, `beyond` those beyond a limit, with the
    consequence. `ttl_ms` is the `LossRules.robot_ttl_ms` that it reports, 0 if it never stops by
    itself, null if it reports none.
    """

    connected: bool
    problem: Sentence | None = None
    gauges: dict[str, float] = {}
    beyond: dict[str, Literal["warn", "stop"]] = {}
    ttl_ms: float | None = None


class AboardInfo(Outgoing):
    """The person aboard, whose hand control outranks every operator.

    `mode` is ``free`` while an operator may drive, ``hand`` while the person does, ``pause`` after
    that, ``stopped`` by their own Stop, ``lost`` while their control does not answer. `reason` is a
    sentence, null while an operator may drive. `asked` is their newest request, `asks` its rising
    number, 0 before the first. `takes_part` is true where the person, besides taking over, scales
    the operator's driving by how far they push their stick ahead.
    """

    mode: Literal["free", "hand", "pause", "stopped", "lost"] = "free"
    reason: Sentence | None = None
    asked: Literal["wait", "go_on", "left", "right"] | None = None
    asks: int = 0
    takes_part: bool = False


class SourceStatus(Outgoing):
    """A camera or microphone; `problem` is a sentence, null if it delivers."""

    problem: Sentence | None = None


class ViewStatus(SourceStatus):
    """The driving view; `undated` says that nobody may drive by it, since its age is unknown."""

    undated: Sentence | None = None


class VoiceInfo(Outgoing):
    """The voice at the robot: `speaker` is the number of the viewer who speaks, or null.

    `muted`: the host has muted all voices. `problem` is a sentence about the robot's speaker, null
    if it plays.
    """

    speaker: int | None = None
    muted: bool = False
    problem: Sentence | None = None


class StopInfo(Outgoing):
    """The stop in force: its rising number, and who pressed it, in words that follow “by”.

    `viewer` is their number, null if they are not in the room. A stop that the host has pressed,
    first or again, only the host can release. Its fields are those of `LatchedStop`.
    """

    model_config = ConfigDict(frozen=True, from_attributes=True)

    number: int
    by: Sentence
    viewer: int | None = None
    by_host: bool = False


class Tape(Outgoing):
    """Whether everything is being recorded; `why` is a sentence: what for, or why it is not."""

    running: bool
    why: Sentence
    can_disown: Annotated[bool, Field(exclude_if=not_)] = False
    """Whether the page offers `Disown` at the end of a turn."""
    asks_task: Annotated[bool, Field(exclude_if=not_)] = False
    """Whether the page asks operators for `SetTask`."""


class _Room(Outgoing):
    """The parts of the room that everybody sees."""

    type: str
    viewers: list[ViewerInfo]
    turn: TurnInfo
    call: CallInfo | None = None
    stop: StopInfo | None = None
    host_settings: HostSettings = HostSettings()
    robot: RobotStatus
    video: ViewStatus = ViewStatus()
    audio: SourceStatus = SourceStatus()
    voice: VoiceInfo | None = None
    """Null where nobody can speak through the robot."""
    tape: Tape | None = None
    """Null where the host does not record."""
    aboard: AboardInfo | None = None
    """Null where nobody sits in the robot."""
    cameras: list[SourceStatus] = []
    """In the order of `Hello.cameras`."""
    controls: dict[str, float] = {}
    """The values of the controls that were set, in the encoding of `Operate`."""
    no_way_in: Sentence | None = None
    """Why nobody new can connect from elsewhere, though those who are here stay."""


class RoomState(_Room):
    """The state of the room that everybody sees, sent once; `RoomChange` updates it."""

    type: Literal["room"] = "room"


class RoomChange(_Room):
    """A change of the room: `viewers` who are new or changed, and the parts that changed.

    `gone` are the numbers of those who left since the previous message. An unchanged part is
    absent, so that a change is small enough for a modem; `wax.protocol.room_change` makes one.
    """

    type: Literal["room_change"] = "room_change"
    gone: list[int]


class Playout(Outgoing):
    """The synchronisation policy's targets for this page's two jitter buffers.

    Null leaves a buffer's delay to the browser or the page's built-in player, whichever plays the
    sound. `player` says which that is; "auto" is the built-in one where it can run. `reason` is a
    sentence for people.
    """

    type: Literal["playout"] = "playout"
    policy: str
    player: Literal["auto", "browser", "built-in"]
    sound_target_ms: float | None
    picture_target_ms: float | None
    reason: Sentence


class Served(Outgoing):
    """What this viewer is sent now, and the estimate of their link; sent when it changes."""

    type: Literal["served"] = "served"
    rendition: str | None
    """Null is no picture."""
    picture_hz: float
    """The picture rate with the layers sent."""
    sound_mu_ms: int | None
    """Null is no sound."""
    sound_bps: int
    sound_channels: int
    redundancy: int
    """Earlier units in each packet of sound."""
    link_bps: int
    used_bps: int
    queue_ms: float
    in_step: bool
    """False where the link cannot carry both in sync: each plays as soon as it can."""
    reason: Sentence
    """Why the viewer does not get more."""
    layers: int | None = None
    """Temporal layers sent."""
    layers_made: int | None = None
    """Temporal layers encoded."""
    cameras: list[str | None] = []
    """The other cameras' renditions; null for one that this page does not show, or that the driving
    view leaves no bitrate for."""


class RtpClock(Outgoing):
    """How RTP time maps to capture time: captured = origin + (rtp - rtp_origin) / rate."""

    type: Literal["rtp_clock"] = "rtp_clock"
    kind: Literal["audio", "video"]
    rtp_origin: int
    rate_hz: int
    origin_server_ms: float


class Units(Outgoing):
    """Which packets end a media unit of the sound: the time of one, and the distance to the next.

    Both are in RTP time, modulo 2³².
    """

    type: Literal["units"] = "units"
    last_rtp: int
    length: int


class DriveStatus(Outgoing):
    """The status of the operator's commands; sent when it changes.

    `reason` is why the robot does not move, or moves more slowly than commanded; `share` is the
    fraction of the commanded speed that is left: 1 if nothing slows it, 0 if it is held.
    """

    type: Literal["drive_status"] = "drive_status"
    moving: bool
    reason: Sentence | None
    share: float


class Driven(Outgoing):
    """The set-point that the robot was sent last, for whoever asked to `Follow`.

    Sent when it changes, at most 20 times a second; it is in force since `server_ms` at the latest.
    `reason` is the short name of why the robot is held, `limit` of why it is slower than commanded,
    as on the tape.
    """

    type: Literal["driven"] = "driven"
    server_ms: float
    turn: int
    linear_mps: float
    angular_rps: float
    lateral_mps: float
    reason: str | None
    limit: str | None


class Heard(Outgoing):
    """Whether this viewer's voice plays at the robot; sent when that changes.

    `reason` is a sentence that says why it does not, null if it does or if they are silent.
    """

    type: Literal["heard"] = "heard"
    heard: bool
    reason: Sentence | None


class Notice(Outgoing):
    """A sentence for this viewer, such as why a request was refused."""

    type: Literal["notice"] = "notice"
    text: Sentence


class Opening(Outgoing):
    """One span of opening hours (since 1970)."""

    opens_wall_ms: float
    closes_wall_ms: float


class Ended(Outgoing):
    """The last message to a viewer who may not stay.

    `text` says why. `openings` are the robot's opening hours of the coming week, the next first, at
    which the page reconnects by itself; empty if hours are not the reason, or if they are unknown.
    """

    type: Literal["ended"] = "ended"
    text: Sentence
    openings: list[Opening]


class ConsoleViewer(Outgoing):
    """What only the host sees of a viewer; null where unknown.

    `address` is shortened. `round_trip_ms` and `picture_ms` (the picture's age) are current.
    """

    id: int
    address: str
    invited: bool
    muted: bool
    round_trip_ms: float | None
    picture_ms: float | None
    rendition: str | None


class Presser(Outgoing):
    """A shortened address from which Stop was pressed in the last minutes, or that is `muted`.

    `by` is who pressed last, in words that follow “by”; `presses` includes refused ones.
    """

    id: int
    address: str
    by: Sentence
    presses: int
    muted: bool


class Console(Outgoing):
    """What only the host sees; sent when it changes.

    `opens_wall_ms` (since 1970) is the next opening by the hours, null if open or unknown.
    `pressers` are those of the last ten minutes, the newest first, without operators and hosts.
    `reused` is the shortened address that used a replaced host's cookie, perhaps a stolen copy;
    null if none did. `problems` are sentences about what only the host can fix, such as failing
    webhooks or a tunnel that is down.
    """

    type: Literal["console"] = "console"
    viewers: list[ConsoleViewer]
    closed: bool
    opens_wall_ms: float | None
    pressers: list[Presser] = []
    reused: str | None = None
    problems: list[Sentence] = []


class InvitationLink(Outgoing):
    """An invitation: its link is the page's address with ``/#invite=`` and the token.

    `page` is that address if the server knows it; otherwise the host's browser uses its own.
    """

    type: Literal["invitation"] = "invitation"
    page: str
    token: str
    purpose: Literal["watch", "queue"]
    uses: int
    ends_wall_ms: float


class Seat(Outgoing):
    """A LiveKit room's address, and a token that admits this person for the next five minutes."""

    url: str
    token: str


class SentToRoom(Outgoing):
    """Sends the page to watch elsewhere: the robot's own places, or its upload, are taken.

    It uses the first of `rooms`, or the second if that one fails; `links` are pages of other
    servers. `hello` is what the page would receive here, with viewer 0. `wall_ms` is when this was
    written, by the clock of the pictures' capture times.
    """

    type: Literal["sent_to_room"] = "sent_to_room"
    wall_ms: int
    rooms: list[Seat]
    links: list[str]
    hello: Hello


class Told(Outgoing):
    """The state of the room, sent once a second to everybody in the LiveKit rooms.

    Its viewers are only the operator and the head of the queue, since LiveKit's messages hold
    15 kB. One's own place comes with each answer to ``POST /api/queue``. `watching` counts everyone
    but the operator, here and in the LiveKit rooms.
    """

    type: Literal["told"] = "told"
    server_ms: float
    watching: int
    room: RoomState


class Goodbye(Outgoing):
    """The last message of a server that stops or restarts; the page reconnects by itself."""

    type: Literal["goodbye"] = "goodbye"
    text: Sentence


DriveIn = Drive | Operate | Ping | Report
HostIn = EndTurn | Remove | Mute | MuteAddress | Announce | Invite | SignOutOthers | SwitchAct
StateIn = (
    SetName
    | Join
    | Leave
    | Here
    | Stop
    | Release
    | Want
    | Look
    | KeepTape
    | SetTask
    | Disown
    | Follow
    | Received
    | HostIn
)
DriveOut = Pong | Beat | Operated
StateOut = (
    Hello
    | RoomState
    | RoomChange
    | Playout
    | Served
    | RtpClock
    | Units
    | DriveStatus
    | Driven
    | Heard
    | Notice
    | Goodbye
    | Ended
    | Console
    | InvitationLink
    | SentToRoom
    | Told
)

DRIVE_COLUMNS: Final = compact.by_type(*get_args(DriveIn), *get_args(DriveOut))
"""The columns of the drive channel's rows, by type."""

_DRIVE: TypeAdapter[DriveIn] = TypeAdapter(Annotated[DriveIn, Field(discriminator="type")])
_STATE: TypeAdapter[StateIn] = TypeAdapter(Annotated[StateIn, Field(discriminator="type")])


def parse_drive(data: str | bytes) -> DriveIn:
    """Parse a message of the drive channel; raises `ProtocolError`."""
    return foreign_json.read(data, MAX_DRIVE_BYTES, _drive)


def parse_state(data: str | bytes) -> StateIn:
    """Parse a message of the state channel; raises `ProtocolError`."""
    return foreign_json.read(data, MAX_STATE_BYTES, _STATE.validate_json)


def _drive(row: bytes) -> DriveIn:
    return _DRIVE.validate_python(compact.read(row, DRIVE_COLUMNS))
