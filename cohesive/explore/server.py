"""The page of `cohesive explore`: a server on this machine alone, with a token in its address."""

from __future__ import annotations

import json
import secrets
import threading
from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from typing import Any

from ..errors import SceneError
from ..outcome.page import filled
from .explorer import Explorer

#: largest request, bytes: a measured curve of a million rows
_LARGEST = 50_000_000

#: seconds in which the next part of a request must come, or of an answer be taken; a page that is idle asks anew
_PATIENCE = 30.0

#: names by which a browser on this machine may ask; another one would be a page elsewhere that asks through it
_HOSTS = ("127.0.0.1", "localhost")

#: what a page may ask: its name in the address, and how it is answered from the changes and all else that was asked
_ACTIONS: dict[str, Callable[[Explorer, dict[str, Any], dict[str, Any]], dict[str, Any]]] = {
    "run": lambda explorer, changes, asked: explorer.answer(changes, asked.get("over")),
    "toml": lambda explorer, changes, asked: {"text": explorer.toml(changes)},
    "python": lambda explorer, changes, asked: {"text": explorer.python(changes)},
    "curve": lambda explorer, changes, asked: explorer.measured(str(asked["text"]), str(asked["name"])),
    "fit": lambda explorer, changes, asked: explorer.fitted(changes, asked.get("text"), str(asked.get("name"))),
}


class ExploreServer(ThreadingHTTPServer):
    """Serves one scene. Browsers hold connections open, so that each has a thread; runs go one after the other, as gmsh must.

    Attributes
    ----------
    address : what to open
    """

    def __init__(self, explorer: Explorer, port: int = 0) -> None:
        self.explorer, self.token, self.running = explorer, secrets.token_urlsafe(16), threading.Lock()
        super().__init__(("127.0.0.1", port), _Handler)
        self.address = f"http://127.0.0.1:{self.server_port}/{self.token}/"


class _Handler(BaseHTTPRequestHandler):
    server: ExploreServer
    timeout = _PATIENCE

    def handle(self) -> None:
        """All requests of a connection, until it is closed or nothing more comes."""
        with suppress(ConnectionError):
            super().handle()

    def do_GET(self) -> None:
        """The page."""
        if self._path() != "":
            return self._refuse()
        template = resources.files("cohesive.explore").joinpath("explore.html").read_text(encoding="utf-8")
        explorer = self.server.explorer
        facts = {"title": explorer.scene.title, "controls": explorer.controls(), "measured": explorer.measured()}
        self._send(filled(template, facts).encode(), "text/html; charset=utf-8")

    def do_POST(self) -> None:
        """What the page asks: {"changes": {key: value}, ...} as JSON."""
        length = self.headers.get("Content-Length") or "0"
        action = _ACTIONS.get(self._path() or "")
        is_length = length.isdecimal() and len(length) <= len(str(_LARGEST)) and int(length) <= _LARGEST
        if action is None or not is_length:
            return self._refuse()
        content = self.rfile.read(int(length))
        if len(content) < int(length):  # the page has left
            return None
        try:
            asked = json.loads(content)
            with self.server.running:
                answer = action(self.server.explorer, dict(asked.get("changes", {})), asked)
        except SceneError as error:
            answer = {"error": str(error)}
        except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            answer = {"error": f"the request cannot be read: {error}"}
        self._send(json.dumps(answer).encode(), "application/json")

    def _path(self) -> str | None:
        """What stands behind the token; None for another token, or a name that is not this machine's."""
        host = (self.headers.get("Host") or "").rsplit(":", 1)[0]
        parts = self.path.split("/")
        is_ours = len(parts) == 3 and secrets.compare_digest(parts[1].encode(), self.server.token.encode())
        return parts[2] if is_ours and host in _HOSTS else None

    def _refuse(self) -> None:
        self.send_error(HTTPStatus.NOT_FOUND)

    def _send(self, body: bytes, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in (("Content-Type", kind), ("Content-Length", str(len(body))), ("Cache-Control", "no-store")):
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing: the terminal is the user's."""
