"""What the viewer is given: BSDFs or files of them, each with a name of its own.

A file is read at once, so that what is wrong is told at the prompt and not on the page. Damaged files are shown as far
as they can be read, since to see what is wrong is what a viewer is for; the page says what was mended.
"""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from bsdftree._bsdf import Bsdf, load


@dataclass(frozen=True)
class Exhibit:
    """A BSDF in the viewer, or the file of it; exactly one of ``content`` and ``path`` is there."""

    name: str
    repairs: Sequence[str] = ()
    content: bytes = b""
    path: Path | None = None

    def packed(self) -> bytes:
        """Return it in little space: packed, unless the file is damaged, and has to be seen as it is."""
        if self.path is None:
            return self.content
        return self.path.read_bytes() if self.repairs else _packed(load(self.path, strict=False))


def exhibits(bsdfs: Iterable[Bsdf | str | os.PathLike[str]]) -> list[Exhibit]:
    """Look into what is to be shown; the same file is shown once.

    Raises
    ------
    ValueError
        If a file is not a BSDF.
    OSError
        If a file cannot be read.
    """
    given = list(bsdfs)
    paths = list(dict.fromkeys(Path(os.path.abspath(b)) for b in given if not isinstance(b, Bsdf)))
    of_files = [_of_file(path, name) for path, name in zip(paths, distinct_names(paths), strict=True)]
    by_path = {file.path: file for file in of_files}
    taken = Counter(file.name for file in of_files)
    # In the order given.
    result = dict.fromkeys(_of(b, taken) if isinstance(b, Bsdf) else by_path[Path(os.path.abspath(b))] for b in given)
    return list(result)


def distinct_names(paths: Sequence[Path]) -> list[str]:
    """Return the ends of paths, as short as they can be without two being the same.

    Examples
    --------
    >>> distinct_names([Path("/a/blinds.xml"), Path("/b/blinds.xml"), Path("/b/film.xml")])
    ['a/blinds.xml', 'b/blinds.xml', 'film.xml']
    """

    def end(path: Path, n: int) -> str:
        return "/".join(path.parts[-n:]).lstrip("/")

    ends = {path: 1 for path in paths}
    while True:
        counts = Counter(end(path, n) for path, n in ends.items())
        same = [path for path, n in ends.items() if counts[end(path, n)] > 1 and n < len(path.parts)]
        if not same:
            return [end(path, ends[path]) for path in paths]
        ends |= {path: ends[path] + 1 for path in same}


def _of_file(path: Path, name: str) -> Exhibit:
    bsdf = load(path, strict=False)
    try:
        bsdf.verify()
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return Exhibit(name, tuple(bsdf.repairs), path=path)


def _of(bsdf: Bsdf, taken: Counter[str]) -> Exhibit:
    name = bsdf.name.replace("/", "_") or "BSDF"
    taken[name] += 1
    return Exhibit(name if taken[name] == 1 else f"{name} ({taken[name]})", content=_packed(bsdf))


def _packed(bsdf: Bsdf) -> bytes:
    # A hundredth larger than the smallest, thirty times sooner.
    with tempfile.TemporaryDirectory(prefix="bsdftree-") as folder:
        path = Path(folder) / "packed.bsdft"
        bsdf.save(path, packed=True, level=3)
        return path.read_bytes()
