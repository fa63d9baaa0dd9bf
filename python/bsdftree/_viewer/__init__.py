"""The viewer with files in it: as a page of this machine, or as one file to keep.

In go BSDFs, or paths of files, which are looked into before anything is shown. Out comes the page that ``make web``
built (``built.py``), on loopback (``server.py``), or with everything inside (``export.py``). What the page does is in
``web/``.
"""

from __future__ import annotations

import os
import webbrowser
from collections.abc import Sequence
from types import TracebackType

from bsdftree._bsdf import Bsdf
from bsdftree._viewer.built import page_files
from bsdftree._viewer.exhibit import Exhibit, exhibits
from bsdftree._viewer.export import one_page
from bsdftree._viewer.server import Server
from bsdftree._whole_file import whole_file

__all__ = ["Viewer", "save_view", "view"]


class Viewer:
    """The viewer while it is served; ends with :meth:`close`, at the end of a ``with``, or with the program.

    Attributes
    ----------
    url : str
        Where it is: on this machine, for its browsers alone.
    """

    def __init__(self, files: Sequence[Exhibit], port: int = 0) -> None:
        self._server = Server(page_files(), files, port)
        self.url = self._server.url

    def open(self) -> bool:
        """Open the system's browser; whether there is one."""
        return webbrowser.open(self.url)

    def wait(self) -> None:
        """Return when it is closed."""
        self._server.wait()

    def close(self) -> None:
        """End it."""
        self._server.close()

    def __enter__(self) -> Viewer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Viewer {self.url}>"


def view(*bsdfs: Bsdf | str | os.PathLike[str], port: int = 0, browser: bool = True) -> Viewer:
    """Serve the viewer to the browsers of this machine, with BSDFs in it: the first is shown, the second beside it.

    Parameters
    ----------
    bsdfs
        BSDFs, or files. Files are read anew whenever the page is loaded.
    port
        Of 127.0.0.1; by default any that is free.
    browser
        Whether to open the system's browser.

    Raises
    ------
    ValueError
        If a file is not a BSDF.
    OSError
        If a file cannot be read, the port is taken, or the viewer was not built.

    Examples
    --------
    >>> white = Bsdf.from_function(lambda i, o: 0.2 + 0 * i[:, 0], components=["reflection_back"])
    >>> with view(white, browser=False) as viewer:  # doctest: +SKIP
    ...     print(viewer.url)
    http://127.0.0.1:40613/
    """
    page_files()
    viewer = Viewer(exhibits(bsdfs), port)
    if browser:
        viewer.open()
    return viewer


def save_view(path: str | os.PathLike[str], *bsdfs: Bsdf | str | os.PathLike[str]) -> None:
    """Write the viewer with BSDFs in it as one HTML file, which needs no server and no network.

    Parameters
    ----------
    path
        The file to write.
    bsdfs
        BSDFs, or files.

    Raises
    ------
    ValueError
        If a file is not a BSDF.
    OSError
        If a file cannot be read or written, or the viewer was not built.
    """
    page_files()
    write_view(path, exhibits(bsdfs))


def write_view(path: str | os.PathLike[str], files: Sequence[Exhibit]) -> None:
    """:func:`save_view` of what was looked into."""
    with whole_file(path) as temporary, temporary.open("wb") as stream:
        stream.writelines(one_page(page_files(), files))
