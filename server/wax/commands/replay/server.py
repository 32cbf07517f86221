"""The HTTP server of `wax replay`: the page, the tape's events, and its picture and sound."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import structlog
from aiohttp import web

from wax.errors import NotForUsError, StartError, StateError
from wax.web.routes import PAGE

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from pydantic import BaseModel

    from wax.commands.replay.library import Library
    from wax.web.guards import Guards

    Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

_LOG = structlog.get_logger(__name__)

FOLDER: Final = "replay"
"""The built page, beside that of the robot."""
_NOT_STORED: Final = {"Cache-Control": "no-store"}
_TYPES: Final = {".webm": "video/webm", ".mp4": "video/mp4"}


class ReplayServer:
    """Serves `library`, which it reads in threads, since a disk may be slow.

    Everything is below the path `secret`: others with an account on this machine can reach its
    ports, but must not see the tape.
    """

    def __init__(
        self, library: Library, guards: Guards, secret: str, page: Path = PAGE / FOLDER
    ) -> None:
        self._at = f"/{secret}"
        self._library = library
        self._guards = guards
        self._page = page

    def application(self) -> web.Application:
        """Return the application; raises `StartError` if the page was not built."""
        if not (self._page / "index.html").is_file():
            raise StartError("the page is not built; run `make run`, or `pip install .` again")
        application = web.Application(
            client_max_size=1024, middlewares=[_tell_errors, *self._guards.middlewares]
        )
        application.on_response_prepare.append(self._guards.add_headers)
        application.add_routes(
            [
                web.get(f"{self._at}/", self.page),
                web.get(f"{self._at}/api/tape", self.listing),
                web.get(f"{self._at}/api/tape/{{name}}", self.content),
                web.get(f"{self._at}/media/{{name}}", self.media),
                web.get(f"{self._at}/media/{{name}}/{{camera:[0-9]{{1,3}}}}", self.media),
                web.static(f"{self._at}/", self._page),
            ]
        )
        return application

    async def page(self, request: web.Request) -> web.StreamResponse:  # noqa: ARG002  # aiohttp's form
        return web.FileResponse(self._page / "index.html", headers={"Cache-Control": "no-cache"})

    async def listing(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        return _json(await asyncio.to_thread(self._library.listing))

    async def content(self, request: web.Request) -> web.Response:
        return _json(await asyncio.to_thread(self._library.content, request.match_info["name"]))

    async def media(self, request: web.Request) -> web.StreamResponse:
        camera = request.match_info.get("camera")
        number = None if camera is None else int(camera)
        path = await asyncio.to_thread(self._library.media, request.match_info["name"], number)
        # It answers requests for ranges, by which a browser seeks.
        return web.FileResponse(
            path,
            headers={"Content-Type": _TYPES[path.suffix], **_NOT_STORED},
        )


def _json(model: BaseModel) -> web.Response:
    response = web.Response(
        text=model.model_dump_json(), content_type="application/json", headers=_NOT_STORED
    )
    response.enable_compression()
    return response


@web.middleware
async def _tell_errors(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Answer each error with a sentence."""
    try:
        return await handler(request)
    except NotForUsError as error:
        return web.json_response({"error": str(error)}, status=error.status)
    except StateError as error:
        return web.json_response({"error": str(error)}, status=404)
    except web.HTTPException as error:
        if error.status < 400:
            raise
        return web.json_response({"error": error.reason}, status=error.status)
    except Exception:
        _LOG.exception("request failed", path=request.path)
        return web.json_response({"error": "this failed; see the terminal"}, status=500)
