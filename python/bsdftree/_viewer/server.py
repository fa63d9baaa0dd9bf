"""The page on loopback: its own files and the BSDFs given, each at an address of its own, and nothing else of the disk.

What is asked for is looked up in a table, so there are no paths to climb out of. Names of hosts other than those of
this machine are refused, or any page in the browser could have its own name lead here and read the files (DNS
rebinding). Other programs of this machine can read what is served while it is.
"""

from __future__ import annotations

import errno
import io
import os
import shutil
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import BinaryIO
from urllib.parse import quote, unquote

from bsdftree._viewer.built import TYPES
from bsdftree._viewer.exhibit import Exhibit

HOST = "127.0.0.1"
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "
    "img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    # Files may change, and others may be served at this port tomorrow.
    "Cache-Control": "no-store",
}
# A client that sends or takes nothing for so long is given up [s].
_PATIENCE = 30


class Server:
    """The page, served by a thread until :meth:`close`."""

    def __init__(self, page: Mapping[str, Path], files: Sequence[Exhibit], port: int = 0) -> None:
        self._served = _Served(page, files, port)
        self.url = f"http://{HOST}:{self._served.server_port}/"
        # How long closing may take [s].
        self._thread = threading.Thread(target=self._served.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    def wait(self) -> None:
        """Return when it is closed."""
        # In pieces, or Ctrl-C would wait too on Windows.
        while self._thread.is_alive():
            self._thread.join(0.5)

    def close(self) -> None:
        """End it; more than once does nothing."""
        if self._thread.is_alive():
            self._served.shutdown()
            self._thread.join()
        self._served.server_close()


class _Served(ThreadingHTTPServer):
    daemon_threads = True
    # On Windows two programs could share a port by it.
    allow_reuse_address = os.name != "nt"

    def __init__(self, page: Mapping[str, Path], files: Sequence[Exhibit], port: int) -> None:
        try:
            super().__init__((HOST, port), _Answer)
        except OSError as error:
            if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                raise
            why = "is taken by another program" if error.errno == errno.EADDRINUSE else "is not allowed to you"
            raise OSError(error.errno, f"port {port} {why}; give another, or none for any that is free") from None
        self.hosts = {f"{HOST}:{self.server_port}", f"localhost:{self.server_port}"}
        if self.server_port == 80:
            self.hosts |= {HOST, "localhost"}
        self.places: dict[str, tuple[str, Path | bytes]] = {
            f"/{name}": (TYPES[path.suffix], path) for name, path in page.items()
        }
        # Never as XML, of which browsers make pages.
        self.places |= {f"/files/{f.name}": ("application/octet-stream", f.path or f.content) for f in files}
        self.start = "/index.html" + "".join(
            # An address in an address: quoted for either.
            f"{'&' if k else '?'}file={quote(quote(f'files/{file.name}'))}"
            for k, file in enumerate(files)
        )

    def handle_error(self, request: object, client_address: object) -> None:
        """Say what went wrong, but not that a browser went away."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


class _Answer(BaseHTTPRequestHandler):
    server: _Served
    server_version = "bsdftree"
    sys_version = ""
    timeout = _PATIENCE

    def do_GET(self) -> None:
        """Answer with a file."""
        self._answer(with_content=True)

    def do_HEAD(self) -> None:
        """Answer with what a file would come with."""
        self._answer(with_content=False)

    def log_message(self, *_: object) -> None:
        """Say nothing."""

    def _answer(self, with_content: bool) -> None:
        if self.headers.get("Host") not in self.server.hosts:
            return self._refuse(HTTPStatus.MISDIRECTED_REQUEST, "this is not the host that was asked for")
        place = unquote(self.path.partition("?")[0])
        if place == "/":
            return self._send(HTTPStatus.FOUND, "text/plain", io.BytesIO(), 0, {"Location": self.server.start})
        kind, content = self.server.places.get(place, ("", b""))
        if not kind:
            return self._refuse(HTTPStatus.NOT_FOUND, "nothing of that name is served")
        if isinstance(content, bytes):
            return self._send(HTTPStatus.OK, kind, io.BytesIO(content if with_content else b""), len(content))
        try:
            stream = content.open("rb")
        except OSError as error:
            return self._refuse(HTTPStatus.GONE, f"the file cannot be read any more: {error.strerror}")
        with stream:
            length = os.fstat(stream.fileno()).st_size
            self._send(HTTPStatus.OK, kind, stream if with_content else io.BytesIO(), length)

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        text = f"{why}\n".encode()
        self._send(status, "text/plain; charset=utf-8", io.BytesIO(text), len(text))

    def _send(
        self, status: HTTPStatus, kind: str, content: BinaryIO, length: int, more: Mapping[str, str] | None = None
    ) -> None:
        self.send_response(status)
        for name, value in {"Content-Type": kind, "Content-Length": str(length), **HEADERS, **(more or {})}.items():
            self.send_header(name, value)
        self.end_headers()
        with suppress(BrokenPipeError, ConnectionResetError, TimeoutError):
            shutil.copyfileobj(content, self.wfile)
