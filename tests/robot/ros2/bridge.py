"""A rosbridge server for one robot, written from the protocol: a real one needs ROS.

It implements, of `ROSBRIDGE_PROTOCOL.md`, `advertise`, `publish`, `subscribe`, `call_service`
for three services of rosapi, and `status` for errors.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import threading
import time
from typing import Any

from aiohttp import WSMsgType, web
from tests.free_port import free_port
from tests.robot.ros2.base import CommandLog, Told

from wax.driver.interface import Twist

NODE = "/rosbridge_websocket"


class Bridge(CommandLog):
    """A server that restarts on the same port; `publishers` are the graph's.

    `driving` is the connection that has last sent motion, `asked` the path and the credentials of
    the last one.
    """

    def __init__(
        self, *, type_name: str = "geometry_msgs/msg/Twist", has_rosapi: bool = True
    ) -> None:
        self.type_name = type_name
        self.has_rosapi = has_rosapi
        self.refuses_by_status = False
        self.publishers = [NODE]
        self.subscribers = ["/base"]
        self.port = free_port()
        self.heard: list[dict[str, Any]] = []
        self.asked: tuple[str, str | None] = "", None
        super().__init__()
        self.lines: set[web.WebSocketResponse] = set()
        self.driving: web.WebSocketResponse | None = None
        self._topics: set[str] = set()
        self._thread: threading.Thread | None = None

    @property
    def url(self) -> str:
        return f"ws://127.0.0.1:{self.port}"

    def start(self) -> Bridge:
        ready = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        self._hears = asyncio.Event()
        self._hears.set()
        self._thread = threading.Thread(target=self._run, args=(ready,))
        self._thread.start()
        assert ready.wait(10)
        return self

    def end(self) -> None:
        """Close every connection; safe to call twice."""
        thread, self._thread = self._thread, None
        if thread is not None:
            self._loop.call_soon_threadsafe(self._end.set)
            thread.join(10)

    def turn_deaf(self, *, deaf: bool) -> None:
        """Stop reading, or resume."""
        change = self._hears.clear if deaf else self._hears.set
        self._loop.call_soon_threadsafe(change)

    def say(self, topic: str, message: object) -> None:
        """Publish to the subscribers."""
        asyncio.run_coroutine_threadsafe(self._publish(topic, message), self._loop).result(5)

    def say_raw(self, text: str) -> None:
        asyncio.run_coroutine_threadsafe(self._send_all(text), self._loop).result(5)

    def _run(self, ready: threading.Event) -> None:
        self._loop.run_until_complete(self._serve(ready))
        self._loop.close()

    async def _serve(self, ready: threading.Event) -> None:
        app = web.Application()
        app.router.add_get("/{path:.*}", self._talk)
        runner = web.AppRunner(app, shutdown_timeout=0.5)
        await runner.setup()
        listening = socket.create_server(("127.0.0.1", self.port))
        await web.SockSite(runner, listening).start()
        ready.set()
        await self._end.wait()
        # asyncio never closes a connection that it accepts in the pass in which its server closes.
        self._loop.remove_reader(listening)
        for _ in range(3):  # it hands over what it has accepted two passes later
            await asyncio.sleep(0)
        for line in list(self.lines):
            await line.close()
        await runner.cleanup()

    async def _talk(self, request: web.Request) -> web.WebSocketResponse:
        self.asked = request.raw_path, request.headers.get("Authorization")
        line = web.WebSocketResponse()
        await line.prepare(request)
        self.lines.add(line)
        try:
            async for frame in line:
                if frame.type is WSMsgType.TEXT:
                    await self._hear(line, json.loads(frame.data))
                # A deaf server reads nothing, as behind a network that carries nothing.
                await self._hears.wait()
        finally:
            self.lines.discard(line)
        return line

    async def _hear(self, line: web.WebSocketResponse, said: dict[str, Any]) -> None:
        if said["op"] != "publish":
            self.heard.append(said)
        match said["op"]:
            case "advertise" if said["type"] != self.type_name:
                words = (
                    f"advertise: Tried to advertise topic {said['topic']} with type {said['type']}"
                    f" but topic has been established with type {self.type_name}"
                )
                await line.send_json({"op": "status", "level": "error", "msg": words})
            case "publish":
                self._note(line, said["msg"])
            case "subscribe":
                self._topics.add(said["topic"])
            case "call_service":
                await line.send_json(self._answer(said))

    def _note(self, line: web.WebSocketResponse, message: dict[str, Any]) -> None:
        stamp = message.get("header", {}).get("stamp", {})
        stamp_ns = stamp.get("sec", 0) * 1_000_000_000 + stamp.get("nanosec", 0)
        twist = message.get("twist", message)
        linear, angular = twist["linear"], twist["angular"]
        set_point = Twist(linear["x"], angular["z"], linear["y"])
        others = sum(map(abs, (linear["z"], angular["x"], angular["y"])))
        if not set_point.is_zero:
            self.driving = line
        with self._lock:
            self._told.append(Told(time.monotonic(), stamp_ns, set_point, others))

    def _answer(self, asked: dict[str, Any]) -> dict[str, Any]:
        answer = {"op": "service_response", "id": asked["id"], "service": asked["service"]}
        name = asked["service"].removeprefix("/rosapi/")
        values: dict[str, Any] = {
            "publishers": self.publishers,
            "subscribers": self.subscribers,
            "type": self.type_name,
        }
        name = "type" if name == "topic_type" else name
        if self.refuses_by_status:  # as ros2-web-bridge does
            words = "TypeError: Cannot read property 'indexOf' of undefined"
            return {"op": "status", "level": "error", "msg": words, "id": asked["id"]}
        if not self.has_rosapi or name not in values:
            return answer | {"values": "Service does not exist", "result": False}
        return answer | {"values": {name: values[name]}, "result": True}

    async def _publish(self, topic: str, message: object) -> None:
        if topic in self._topics:
            await self._send_all(json.dumps({"op": "publish", "topic": topic, "msg": message}))

    async def _send_all(self, text: str) -> None:
        for line in list(self.lines):
            # A connection that fails does not keep the message from the others.
            with contextlib.suppress(ConnectionError):
                await line.send_str(text)
