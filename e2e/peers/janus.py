"""Janus, a gateway written in C: Debian's, with only its streaming plugin, fed by RTP.

Its cost per viewer is our goal. It makes the offers, and its viewers answer them, by its HTTP API,
the only way in Debian's version (1.1).
"""

from __future__ import annotations

import asyncio
import shutil
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.harness.child import kill
from e2e.harness.wait import answers, eventually
from e2e.measure.errors import MeasureError, NotRunError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

MOUNTPOINT: Final = 1
_STARTS_WITHIN_S: Final = 10.0
_FILES: Final = {
    "janus.jcfg": """
general: {
  configs_folder = "@folder"
  debug_level = 3
  session_timeout = 0  # its viewers ask for nothing more
  log_to_file = "@folder/janus.log"
}
certificates: { dtls_ciphers = "DEFAULT" }
media: { ipv6 = false  rtp_port_range = "20000-29999" }
nat: { ice_lite = true  ice_enforce_list = "127.0.0.1"  ignore_mdns = true  ice_ignore_list = "" }
plugins: { disable = "libjanus_audiobridge.so,libjanus_duktape.so,libjanus_echotest.so,\
libjanus_lua.so,libjanus_nosip.so,libjanus_recordplay.so,libjanus_sip.so,libjanus_textroom.so,\
libjanus_videocall.so,libjanus_videoroom.so,libjanus_voicemail.so" }
transports: { disable = "libjanus_websockets.so,libjanus_pfunix.so,libjanus_mqtt.so,\
libjanus_nanomsg.so,libjanus_rabbitmq.so" }
""",
    "janus.transport.http.jcfg": """
general: { base_path = "/janus"  http = true  ip = "127.0.0.1"  port = @api }
""",
    "janus.plugin.streaming.jcfg": """
card: {
  type = "rtp"
  id = 1
  media = (
    { type = "audio"  mid = "a"  port = @audio  pt = 111  codec = "opus" },
    { type = "video"  mid = "v"  port = @video  pt = 96  codec = "vp8"  bufferkf = true }
  )
}
""",
}


@asynccontextmanager
async def running(folder: Path, port: int) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run Janus inside the block, on its caller's core; its API is on `port`.

    Its mountpoint is fed on `port` + 1 and + 2 (`e2e.peers.janus_feed`). Raises `NotRunError` if
    Janus is missing, and `MeasureError` if it does not start.
    """
    program = shutil.which("janus")
    if program is None:
        raise NotRunError("Janus is not installed (Debian: sudo apt-get install -y janus)")
    values = {"folder": folder, "api": port, "audio": port + 1, "video": port + 2}
    for name, text in _FILES.items():
        for key, value in values.items():
            text = text.replace(f"@{key}", str(value))  # noqa: PLW2901  # bit by bit
        (folder / name).write_text(text, encoding="utf-8")
    with (folder / "output.log").open("ab") as log:
        process = await asyncio.create_subprocess_exec(
            program, f"--configs-folder={folder}", "--disable-colors", stdout=log, stderr=log
        )
    try:
        await _answers(port, folder)
        yield process
    finally:
        await kill(process)


async def _answers(port: int, folder: Path) -> None:
    is_there = partial(answers, f"http://127.0.0.1:{port}/janus/info")
    try:
        await eventually(is_there, "Janus answers", within_s=_STARTS_WITHIN_S)
    except AssertionError as error:
        log = (folder / "output.log").read_text(encoding="utf-8", errors="replace").splitlines()
        last = log[-1] if log else "no log"
        raise MeasureError(f"Janus does not start; its log ends: {last}") from error
