"""A server for one page and one user: on the loopback address, behind a token, and of nothing but what is listed here.

Who may ask:

- the address is 127.0.0.1, so no other machine;
- every path begins with a token that only the command's terminal shows, so no other user of this machine, nor a page of
  another site that guesses the port;
- ``Host`` must name the loopback address, so no other site whose name was made to lead here (DNS rebinding), and
  ``Origin``, where a browser states it, this server;
- questions are JSON by their ``Content-Type``, which no form of another site can send unasked.
"""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from typing import Any

from multilayer.bounds import YAML_BYTES
from multilayer.errors import InputError
from multilayer.explore.questions import Questions
from multilayer.json_text import json_text
from multilayer.log import LOGGER

ADDRESS = "127.0.0.1"
_CSS, _SCRIPT = "text/css; charset=utf-8", "text/javascript; charset=utf-8"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'"
)
"""What the page may do: run and show what comes from here, ask here, and never make code or markup of a text."""
_HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",  # the token stands in the address
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_IDLE = 60.0  # s after which a connection that asks nothing is closed


def _part(name: str) -> bytes:
    return resources.files(__package__).joinpath(f"page/{name}").read_bytes()


class Server(ThreadingHTTPServer):
    """The server of one page.

    Parameters
    ----------
    explorer : Questions
        Who answers.
    port : int
        0 for any that is free.

    Raises
    ------
    InputError
        When the port is in use, or not allowed.
    """

    daemon_threads = True
    allow_reuse_address = os.name != "nt"  # of a port just left; Windows would give one that is in use

    def __init__(self, explorer: Questions, port: int = 0) -> None:
        self.explorer, self.token = explorer, secrets.token_urlsafe(24)
        name = explorer.page
        parts = {"explore.css": _CSS, "page.js": _SCRIPT, f"{name}.js": _SCRIPT}
        self.files = {part: (_part(part), kind) for part, kind in parts.items()}
        self.files[""] = (_part(f"{name}.html"), "text/html; charset=utf-8")
        try:
            super().__init__((ADDRESS, port), _Handler)
        except OSError as error:
            remedy = "choose another one, or leave --port out for any that is free"
            raise InputError(f"--port: {port} of {ADDRESS} cannot be had ({error.strerror}); {remedy}") from None
        except OverflowError:
            raise InputError(f"--port: {port} is not allowed; ports go from 1 to 65535") from None

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{ADDRESS}:{self.server_port}/{self.token}/"

    @property
    def hosts(self) -> tuple[str, ...]:
        """What a browser may call this server by."""
        return tuple(f"{name}:{self.server_port}" for name in (ADDRESS, "localhost"))

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Log what broke a connection, as a browser that was closed."""
        del request, client_address
        LOGGER.info("explore: a connection broke", exc_info=True)


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"  # connections stay: a slider moves in many questions
    disable_nagle_algorithm = True  # which would hold back short answers for 40 ms
    server_version, sys_version = "multilayer", ""
    timeout = _IDLE

    def do_GET(self) -> None:
        """Send the page or a part of it."""
        path = self._allowed_path()
        if path is None:
            return
        if path not in self.server.files:
            self._refuse(HTTPStatus.NOT_FOUND)
            return
        self._send(HTTPStatus.OK, *self.server.files[path])

    def do_POST(self) -> None:
        """Answer a question."""
        path = self._allowed_path()
        if path is None:
            return
        if path not in self.server.explorer.answers:
            self._refuse(HTTPStatus.NOT_FOUND)
            return
        if self.headers.get_content_type() != "application/json":
            self._refuse(HTTPStatus.UNSUPPORTED_MEDIA_TYPE)
            return
        length = self.headers.get("Content-Length", "")
        if not length.isascii() or not length.isdecimal():
            self._refuse(HTTPStatus.LENGTH_REQUIRED)
            return
        if len(length) > 12 or int(length) > YAML_BYTES.most:
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            return
        request = parsed(self.rfile.read(int(length)))
        if request is None:
            self._refuse(HTTPStatus.BAD_REQUEST)
            return
        try:
            content = json_text(self.server.explorer.answer(path, request))
        except Exception as error:  # the page stays, whatever it was
            LOGGER.exception("explore: %s failed", path)
            text = f"multilayer failed on something it should have foreseen ({type(error).__name__}): a bug; undo it"
            content = json_text({"problems": [{"path": "", "text": text}], "warnings": []})
        self._send(HTTPStatus.OK, content.encode(), "application/json")

    def _allowed_path(self) -> str | None:
        """Return the path behind the token; None, with the refusal sent, for who may not ask."""
        own = [f"http://{host}" for host in self.server.hosts]
        if self.headers.get("Host") not in self.server.hosts or self.headers.get("Origin", own[0]) not in own:
            self._refuse(HTTPStatus.FORBIDDEN)
            return None
        _, token, *rest = [*self.path.split("/", 2), ""]
        # compared as bytes: a path may hold any character
        if not secrets.compare_digest(token.encode(), self.server.token.encode()):
            self._refuse(HTTPStatus.FORBIDDEN)
            return None
        return rest[0]

    def _refuse(self, status: HTTPStatus) -> None:
        self.close_connection = True  # what else was sent is not read
        self._send(status, f"{status.value} {status.phrase}\n".encode(), "text/plain; charset=utf-8")

    def _send(self, status: HTTPStatus, content: bytes, kind: str) -> None:
        self.send_response(status)
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Keep silent: addresses hold the token."""


def parsed(content: bytes) -> Mapping[str, Any] | None:
    """Return a question from its JSON; None where it is none."""
    try:
        request = json.loads(content, parse_constant=_refuse_constant)
    except (ValueError, RecursionError):
        return None
    return request if isinstance(request, dict) else None


def _refuse_constant(name: str) -> None:
    raise ValueError(name)  # NaN and infinities are no JSON
