"""The page as ``make web`` built it: files by name, beside this one."""

from __future__ import annotations

import errno
from pathlib import Path

# Written by web/build.mjs; wheels have it.
_PAGE = Path(__file__).with_name("page")
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".wasm": "application/wasm",
}


def page_files() -> dict[str, Path]:
    """Return the files of the page by name.

    Raises
    ------
    OSError
        If there are none.
    """
    found = {path.name: path for path in _PAGE.glob("*") if path.suffix in TYPES}
    if "index.html" not in found:
        text = "the viewer was not built here; run 'make web' where the source of bsdftree is, or install a wheel"
        raise OSError(errno.ENOENT, text, str(_PAGE))
    return found
