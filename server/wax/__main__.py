"""The `wax` command."""

from __future__ import annotations

import argparse
import asyncio
import io
import json
import logging
import os
import select
import sys
import threading
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, NoReturn, TextIO

from wax import __version__, state_dir
from wax.access import host_link
from wax.clock import SystemClock
from wax.config import settings as config
from wax.errors import ConfigError, StateError, WaxError
from wax.machine import threads
from wax.machine.priority import lower_priority
from wax.records.schema import EXPORTED
from wax.telemetry import configure_logs, quiet_logs

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.commands.proof.proof import Progress
    from wax.config.settings import Settings
    from wax.tape.shelf import Shelf


_INTERRUPTED: Final = 130
"""The exit status that shells use for Ctrl-C."""
_UNREAD: Final = 141
"""The exit status that shells use for SIGPIPE."""

_CONFIG: Final = "the configuration, in TOML; `wax init` writes one"


def command() -> NoReturn:
    """Run the command and end the process, even if a thread hangs in its device.

    Python would kill that thread within its call, for which C++ code, such as OpenCV's, aborts.
    """
    status = until_read(main)
    logging.shutdown()
    if any(thread.daemon for thread in threading.enumerate()):
        os._exit(status)
    sys.exit(status)


def until_read(run: Callable[[], int]) -> int:
    """Run to the end, or until the reader of our output, such as `head`, closes the pipe.

    SIGPIPE, which ends other programs then, would also end a server whose sockets close.
    """
    try:
        try:
            status = run()
        except SystemExit as ended:  # after --help and --version
            status = int(ended.code or 0)
        sys.stdout.flush()
    except BrokenPipeError:
        unread = [stream for stream in (sys.stdout, sys.stderr) if _is_unread(stream)]
        if not unread:
            raise
        with Path(os.devnull).open("wb") as nobody:
            for stream in unread:  # Python flushes its buffer at exit
                os.dup2(nobody.fileno(), stream.fileno())
        return _UNREAD
    return status


def _is_unread(stream: TextIO) -> bool:
    """Whether this is a pipe without a reader."""
    asked = select.poll()
    asked.register(stream.fileno(), 0)
    return any(events & (select.POLLERR | select.POLLHUP) for _, events in asked.poll(0))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is 0 for success, 1 for failure, 2 for wrong usage."""
    _open_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a terminal may lack a character
            stream.reconfigure(errors="backslashreplace")
    # Containers often start with a umask of 0: nobody else must be able to write to our files.
    os.umask(os.umask(0o077) | 0o002)
    arguments = _parser().parse_args(argv)
    try:
        return _COMMANDS.get(arguments.command, _run)(arguments)
    except ConfigError as error:
        print(f"wax: {error}", file=sys.stderr)
        return 2
    except WaxError as error:
        print(f"wax: {error}", file=sys.stderr)
        return 1


def _open_streams() -> None:
    """Open the null device in place of each closed standard stream.

    Otherwise the stream is None, and the next socket gets its descriptor.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            number = os.open(os.devnull, os.O_RDWR)
            os.set_inheritable(number, True)
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8"))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="wax", description="Serve a robot to browsers: picture, sound, and turns to drive."
    )
    parser.add_argument("--version", action="version", version=f"wax {__version__}")
    _add_serving(parser, default=None)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    run = commands.add_parser(
        "run",
        help="serve (also without a command)",
        description="Serve until Ctrl-C. Without a configuration the robot is simulated.",
    )
    _add_serving(run, default=argparse.SUPPRESS)
    commands.add_parser(
        "devices", help="list cameras, microphones, serial ports, drivers and encoders"
    )
    _add_config(commands)
    _add_init(commands)
    _add_host_link(commands)
    _add_glass(commands)
    _add_new_driver(commands)
    _add_prove_stop(commands)
    _add_records(commands)
    _add_tape(commands)
    _add_hook(commands)
    _add_replay(commands)
    _add_doctor(commands)
    return parser


def _add_serving(parser: argparse.ArgumentParser, *, default: str | None) -> None:
    """Accept these before and after `run`, where they override those before it."""
    defaults = config.Settings()
    parser.add_argument("--config", type=Path, metavar="FILE", default=default, help=_CONFIG)
    parser.add_argument(
        "--host", default=default, help="where to listen; 0.0.0.0 lets other devices in"
    )
    parser.add_argument(
        "--port", type=int, default=default, help=f"the port of the page ({defaults.server.port})"
    )
    parser.add_argument(
        "--https",
        action="store_true",
        default=default,
        help="serve HTTPS, with a certificate made here",
    )
    parser.add_argument(
        "--udp-port",
        type=int,
        default=default,
        help=f"the port of picture, sound and commands ({defaults.network.udp_port})",
    )


def _add_config(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    shown = commands.add_parser(
        "config",
        help="show the keys that drivers bring, with their reasons and ranges",
        description="Show the tables [robot.NAME] of drivers. All other keys are in"
        " config/wax.toml, which `python -m wax.config` prints.",
    )
    shown.add_argument(
        "drivers",
        nargs="*",
        metavar="DRIVER",
        help="as in [robot] driver; all that are installed by default",
    )


def _add_init(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    init = commands.add_parser(
        "init",
        help="look at what is plugged in, and write a configuration that starts",
        description="Look at cameras, microphones, speakers and serial ports, ask at most five"
        " questions, and write a commented configuration. Nothing is overwritten; nothing moves.",
    )
    init.add_argument(
        "path",
        nargs="?",
        type=Path,
        default=Path("robot.toml"),
        metavar="FILE",
        help="the file to write (robot.toml)",
    )
    init.add_argument("--yes", action="store_true", help="ask nothing, take the defaults")
    init.add_argument(
        "--serial", metavar="URL", help="the robot's serial port, where it is not listed"
    )
    init.add_argument(
        "--door",
        metavar="LINE",
        help="the line that config/deploy/door.sh printed; a FILE that is there gets it, too",
    )


def _init(arguments: argparse.Namespace) -> int:
    from wax.commands.init.command import init
    from wax.door import line as door_line

    if arguments.door is not None:
        door_line.read(arguments.door)  # a wrong one is said whatever else is wrong
    asks_nothing = arguments.yes or (arguments.door and arguments.path.is_file())
    if not asks_nothing and not sys.stdin.isatty():
        raise ConfigError("no terminal to ask at; pass --yes to take the defaults")
    try:
        with quiet_logs():
            init(
                arguments.path,
                ask=None if asks_nothing else input,
                tell=lambda text: print(text, flush=True),
                port=arguments.serial,
                door=arguments.door,
            )
    except (KeyboardInterrupt, EOFError):
        print("\nNothing was written.", file=sys.stderr)
        return _INTERRUPTED
    return 0


def _takes_config(*commands: argparse.ArgumentParser) -> None:
    """Accept `--config` after the command, too, where it overrides one before it."""
    for command in commands:
        command.add_argument(
            "--config", type=Path, metavar="FILE", default=argparse.SUPPRESS, help=_CONFIG
        )


def _add_host_link(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    link = commands.add_parser(
        "host-link",
        help="print a link that makes you the host of the server that runs here",
        description="Print a link that makes the first browser to open it the host's.",
    )
    _takes_config(link)


def _host_link(arguments: argparse.Namespace) -> int:
    settings = config.load(arguments.config)
    if not settings.access.proxy.host_link:
        raise StateError(
            "[access.proxy] host_link is off: who is host is decided by groups at the sign-in"
        )
    print("\n".join(host_link.request_links(state_dir.find(settings.server.state_dir))))
    return 0


def _add_glass(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    glass = commands.add_parser(
        "glass",
        help="measure the delay from the robot's camera to a screen, both included",
        description="Print the addresses of a page that measures, and of one that only shows the"
        " time code that the robot's camera must see.",
    )
    _takes_config(glass)


def _glass(arguments: argparse.Namespace) -> int:
    settings = config.load(arguments.config)
    links = host_link.request_links(state_dir.find(settings.server.state_dir))
    print("Open one of these where you watch; the first browser becomes the host's:")
    for link in links:
        print(f"  {link.replace('#', '?view=glass#', 1)}")
    print("It shows a time code for the robot's camera. To show it on another screen instead:")
    for link in links:
        print(f"  {link.partition('#')[0]}?view=glass&only=code")
    return 0


def _add_new_driver(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    new = commands.add_parser(
        "new-driver",
        help="write a package with a driver for your own robot, and its test",
        description="Write a package into the folder NAME: a driver in which a few lines are yours,"
        " its table of the configuration, the test that every driver passes, and a stand-in for the"
        " robot.",
    )
    new.add_argument("name", metavar="NAME", help="of the package and driver, such as my_robot")


def _new_driver(arguments: argparse.Namespace) -> int:
    from wax.commands.new_driver.command import new_driver

    print("\n".join(new_driver(arguments.name, Path())))
    return 0


def _add_prove_stop(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    proof = commands.add_parser(
        "prove-stop",
        help="cut each link to the real robot, measure how fast it stops, write a record",
        description="Cut each link between operator and wheels in turn, on the real robot with its"
        " wheels off the floor, and write a one-page record of how fast it stopped. The exit status"
        " is 0 if every stop is proved, 1 if one is late or missing, 2 for wrong usage or a robot"
        " that does not report whether it moves, and 3 if all that could be cut on this robot is"
        " proved, but a link could not be cut.",
    )
    # Also allowed after the command; a default here would override the value given before it.
    _takes_config(proof)
    proof.add_argument(
        "--record", type=Path, metavar="FILE", help="where to write it (prove-stop-DATE-TIME.html)"
    )
    proof.add_argument(
        "--lifted", action="store_true", help="do not ask: the wheels are off the floor"
    )
    proof.add_argument(
        "--repeats",
        type=int,
        default=5,
        metavar="N",
        help="how often each link is cut (5); as often sideways",
    )
    proof.add_argument("--json", action="store_true", help="report progress as lines of JSON")


def _add_records(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    records = commands.add_parser(
        "records",
        help="show who came, who drove, who pressed Stop, and what the host did",
        description="Show what the server has recorded, also while it runs. Times are in UTC.",
    )
    records.add_argument("table", nargs="?", choices=EXPORTED, help="all of them by default")
    records.add_argument("--since", metavar="DATE", help="such as 2026-11-01, or 2026-11-01T18:30")
    format_ = records.add_mutually_exclusive_group()
    format_.add_argument("--csv", action="store_const", const="csv", dest="format", help="as CSV")
    format_.add_argument(
        "--json", action="store_const", const="json", dest="format", help="as JSON"
    )
    records.add_argument("--file", type=Path, metavar="FILE", help="the file, if not as configured")
    _takes_config(records)


def _add_tape(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    tape = commands.add_parser(
        "tape",
        help="list, keep, export, repair or delete what was recorded",
        description="List, keep, export, repair or delete what [recording] has put on disk, also"
        " while it records. Times are in UTC.",
    )
    tape.add_argument("--folder", type=Path, metavar="DIR", help="if it is not as configured")
    acts = tape.add_subparsers(dest="act", required=True)
    acts.add_parser("list", help="show what there is")
    keep = acts.add_parser("keep", help="keep parts until somebody deletes them")
    keep.add_argument("names", nargs="+", metavar="NAME", help="as `wax tape list` has them")
    _add_tape_export(acts)
    acts.add_parser("repair", help="mend what a killed server or a power cut has cut off")
    delete = acts.add_parser("delete", help="delete parts, kept or not")
    delete.add_argument("names", nargs="*", metavar="NAME", help="as `wax tape list` has them")
    delete.add_argument("--all", action="store_true", help="everything")
    delete.add_argument("--before", metavar="DATE", help="such as 2026-11-01, or 2026-11-01T18:30")
    _takes_config(tape, *acts.choices.values())


def _add_tape_export(acts: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    exported = acts.add_parser(
        "export",
        help="write what was recorded in another program's format",
        description="Write what was recorded in another program's format. A dataset whose"
        " export was interrupted goes on when the same command is given again.",
    )
    exported.add_argument("--from", dest="begin", metavar="DATE", help="such as 2026-11-01T18:30")
    exported.add_argument(
        "--to", dest="end", metavar="DATE", help="up to then, written in the same way"
    )
    exported.add_argument("--kept", action="store_true", help="only parts that are kept")
    exported.add_argument("--sound", action="store_true", help="the sound too, with any voices")
    forms = exported.add_mutually_exclusive_group(required=True)
    forms.add_argument(
        "--lerobot", type=Path, metavar="DIR", help="a LeRobot dataset: an episode for each turn"
    )
    forms.add_argument(
        "--mcap", type=Path, metavar="FILE", help="a file for Foxglove, Lichtblick and Rerun"
    )
    mcap = exported.add_argument_group("for --mcap")
    mcap.add_argument("--jpeg", action="store_true", help="pictures as JPEG, even those in H.264")
    lerobot = exported.add_argument_group("for --lerobot")
    lerobot.add_argument("--camera", metavar="NAME", help="another than the driving view")
    lerobot.add_argument("--fps", type=int, metavar="N", help="frames a second (as on the tape)")
    lerobot.add_argument(
        "--action",
        choices=("now", "next"),
        default="now",
        help="whether a frame's action is the set-point in force at it, or at the next frame",
    )
    lerobot.add_argument(
        "--copy", action="store_true", help="copy H.264; each episode begins with a keyframe"
    )
    lerobot.add_argument("--join", action="store_true", help="go on through a Stop or a fault")
    lerobot.add_argument(
        "--drop-under",
        type=float,
        default=1.0,
        metavar="S",
        help="leave out episodes that are shorter (1 s)",
    )


def _add_hook(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    hook = commands.add_parser(
        "hook",
        help="try whether [[hook]] reaches those who are to be told of events",
        description="Try the receivers of events, or describe the events.",
    )
    acts = hook.add_subparsers(dest="act", required=True)
    acts.add_parser("test", help="send each a sample, and say what came back")
    acts.add_parser("schema", help="print the JSON Schema of all events")
    _takes_config(hook, *acts.choices.values())


def _add_replay(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    replay = commands.add_parser(
        "replay",
        help="play what was recorded, in a browser on this machine",
        description="Serve a page on this machine with picture, sound, commands and delays of what"
        " was recorded.",
    )
    replay.add_argument(
        "path",
        nargs="?",
        type=Path,
        metavar="FILE",
        help="one file of the tape, or a folder; all that is recorded by default",
    )
    _takes_config(replay)
    replay.add_argument(
        "--port",
        type=int,
        default=8090,
        metavar="N",
        dest="replay_port",
        help="the port of its page (8090)",
    )


def _add_doctor(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    doctor = commands.add_parser(
        "doctor",
        help="check what the world can reach, the devices and this machine",
        description="Check ports, addresses, certificate, camera, microphone, serial port, clock,"
        " processor and disk, and say what to do about each that is not right. No outside host is"
        " contacted unless one is given or configured.",
    )
    _takes_config(doctor)
    doctor.add_argument(
        "--stun", metavar="HOST:PORT", help="ask this server for the public address"
    )
    doctor.add_argument(
        "--reach", metavar="URL", help="on another machine: try the page there, and a viewer"
    )
    doctor.add_argument("--json", action="store_true", help="report in JSON")


def _settings(arguments: argparse.Namespace) -> Settings:
    settings = config.load(arguments.config)
    server = {"host": arguments.host, "port": arguments.port, "https": arguments.https}
    given = {"server": server, "network": {"udp_port": arguments.udp_port}}
    tree = {
        name: getattr(settings, name).model_dump()
        | {key: value for key, value in keys.items() if value is not None}
        for name, keys in given.items()
    }
    checked = config.parse(tree, "the command line")
    return settings.model_copy(update={"server": checked.server, "network": checked.network})


def _serve(settings: Settings, config_path: Path | None) -> int:
    threads.check(threads.SERVERS)
    # Imported here so that other commands and wrong options need not load the media libraries.
    from wax.app import App
    from wax.edge.bounded_selector import bounded_loop
    from wax.edge.step_watch import StackSampler, StepWatch
    from wax.web.page_urls import page_urls
    from wax.web.senders import limit_key

    configure_logs(settings.log)

    watch = StepWatch()
    app = App(settings=settings, clock=SystemClock(), config_path=config_path, steps=watch.status)

    def ready(port: int) -> None:
        watch.start_counting()
        scheme = "https" if app.tls else "http"
        first, *others = page_urls(settings.server.host, port, scheme)
        print(f"\n  WAX is serving the {settings.robot.driver} robot.\n\n  Here:   {first}")
        for url in others:
            print(f"  Phone:  {url}")
        if not others and settings.server.host == "localhost":
            print("  Phone:  start with --host 0.0.0.0 to let other devices in")
        if app.tls is not None and app.tls.is_self_signed:
            print("\n  The certificate's SHA-256 fingerprint, which browsers show when they ask:")
            print(f"  {app.tls.fingerprint}")
        if not settings.access.proxy.host_link:
            print("\n  Who is host is decided by groups: see [access.proxy].")
        elif sys.stdout.isatty():  # a service's output is logged where others may read it
            print(f"\n  For you, the host; it works once:\n  {app.new_host_link()[0]}")
        elif app.has_host_link:
            print("\n  `wax host-link` prints the link for you, the host.")
        else:
            print("\n  Nobody can become the host: set [server] state_dir, and start again.")
        print("\n  Ctrl-C stops the robot and the server.\n", flush=True)

    # On Windows, the event loop has no selector.
    serves = partial(bounded_loop, limit_key, watch, app.has_people_at)
    loop_factory = None if sys.platform == "win32" else serves
    stacks = StackSampler(watch) if settings.log.level == "debug" else nullcontext()
    with stacks, asyncio.Runner(loop_factory=loop_factory) as runner:
        runner.run(app.run(ready))
    return 0


def _prove_stop(arguments: argparse.Namespace) -> int:
    if os.name != "posix":
        raise ConfigError("the proof needs pseudo-terminals; run it on Linux or macOS")
    from wax.commands.proof.command import prove_stop

    def tell(progress: Progress) -> None:
        told = {"line": str(progress.line), "sentence": progress.line.wire()}
        counts = {"done": progress.done, "of": progress.of}
        print(json.dumps(told | counts) if arguments.json else progress.line, flush=True)

    return prove_stop(
        config.load(arguments.config),
        repeats=arguments.repeats,
        path=arguments.record,
        confirm=lambda: arguments.lifted or _is_lifted(),
        tell=tell,
        has_parent=arguments.json,
    )


def _doctor(arguments: argparse.Namespace) -> int:
    threads.check(threads.DOCTORS)
    from wax.commands.doctor.command import doctor

    with quiet_logs():
        return doctor(
            lambda: _settings(arguments),
            arguments.config,
            tell=lambda text: print(text, flush=True),
            stun=arguments.stun,
            reach_url=arguments.reach,
            as_json=arguments.json,
        )


def _is_lifted() -> bool:
    """Ask at the terminal; raises `ConfigError` if there is none."""
    if not sys.stdin.isatty():
        raise ConfigError("no terminal to ask at; pass --lifted if the wheels are off the floor")
    try:
        return input("Are the wheels off the floor? Type yes: ").strip().lower() == "yes"
    except EOFError:
        return False


def _records(arguments: argparse.Namespace) -> int:
    from wax.records.export import export
    from wax.records.opening import where

    settings = config.load(arguments.config)
    path = arguments.file or where(settings.records, settings.server.state_dir)
    print(export(path, arguments.table, arguments.since, arguments.format or "table"))
    return 0


def _tape(arguments: argparse.Namespace) -> int:
    from wax.tape.command import tape_delete, tape_keep, tape_list, tape_repair
    from wax.tape.shelf import Shelf, where

    settings = config.load(arguments.config)
    shelf = Shelf(arguments.folder or where(settings.recording, settings.server.state_dir))
    acts = {
        "list": lambda: tape_list(shelf),
        "keep": lambda: tape_keep(shelf, arguments.names),
        "export": lambda: _tape_export(shelf, settings, arguments),
        "repair": lambda: tape_repair(shelf),
        "delete": lambda: tape_delete(
            shelf, arguments.names, is_all=arguments.all, before=arguments.before
        ),
    }
    print(acts[arguments.act]())
    return 0


def _tape_export(shelf: Shelf, settings: Settings, arguments: argparse.Namespace) -> str:
    from wax.dataset.command import export_lerobot
    from wax.dataset.mcap_export import export_mcap
    from wax.dataset.parts import DRIVING_VIEW
    from wax.dataset.piece_writer import Options
    from wax.tape.selection import select

    def tell(text: str) -> None:
        print(text, flush=True)

    selection = select(shelf, begin=arguments.begin, end=arguments.end, kept=arguments.kept)
    lower_priority()
    if arguments.mcap is not None:
        jpeg, sound = arguments.jpeg, arguments.sound
        return export_mcap(selection, arguments.mcap, jpeg=jpeg, sound=sound, tell=tell)
    options = Options(
        camera=arguments.camera or DRIVING_VIEW,
        fps=arguments.fps,
        acts_next=arguments.action == "next",
        joins=arguments.join,
        copies=arguments.copy,
        sound=arguments.sound,
        drop_under_s=arguments.drop_under,
        task=settings.recording.task,
        units={one.name: one.unit for one in settings.gauges},
        choices={one.name: one.choices for one in settings.controls if one.choices},
    )
    return export_lerobot(selection, arguments.lerobot, options, tell=tell)


def _hook(arguments: argparse.Namespace) -> int:
    if arguments.act == "schema":
        from wax.protocol.events import schema

        print(json.dumps(schema(), indent=1))
        return 0
    from wax.commands.hook.command import hook_test

    settings = config.load(arguments.config)
    with quiet_logs():
        return asyncio.run(
            hook_test(settings, SystemClock(), tell=lambda text: print(text, flush=True))
        )


def _replay(arguments: argparse.Namespace) -> int:
    from wax.commands.replay.command import replay
    from wax.tape.shelf import where

    settings = config.load(arguments.config)
    path = arguments.path or where(settings.recording, settings.server.state_dir)
    return replay(
        path, arguments.replay_port, settings.log, tell=lambda text: print(text, flush=True)
    )


def _devices(_: argparse.Namespace) -> int:
    from wax.capture.list_devices import list_devices
    from wax.encode.list_encoders import list_encoders
    from wax.plugin import list_plugins
    from wax.robot.serial.list_ports import list_ports

    print("\n".join([*list_devices(), *list_ports(), *list_plugins(), *list_encoders()]))
    return 0


def _config(arguments: argparse.Namespace) -> int:
    print("\n".join(config.describe_drivers(arguments.drivers)))
    return 0


def _run(arguments: argparse.Namespace) -> int:
    return _serve(_settings(arguments), arguments.config)


_COMMANDS: Final[dict[str, Callable[[argparse.Namespace], int]]] = {
    "config": _config,
    "devices": _devices,
    "doctor": _doctor,
    "glass": _glass,
    "hook": _hook,
    "host-link": _host_link,
    "new-driver": _new_driver,
    "init": _init,
    "prove-stop": _prove_stop,
    "records": _records,
    "replay": _replay,
    "tape": _tape,
}


if __name__ == "__main__":
    command()
