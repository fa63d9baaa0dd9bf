"""Radiance's programs as they come in the wheel ``pyradiance``.

In: a name and arguments. Out: what the program prints, or its message as an error. Each is started as it is, without a
shell, with ``RAYPATH`` leading to its library files, and stopped if it takes too long or prints too much.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

Directories = Sequence[str | os.PathLike[str]]


class RadianceError(ValueError):
    """A program of Radiance is missing or failed."""


def find_folder() -> Path | None:
    """Return the folder with ``bin`` and ``lib``, or None if ``pyradiance`` is not installed."""
    spec = find_spec("pyradiance")
    return Path(spec.origin).parent if spec is not None and spec.origin is not None else None


def folder() -> Path:
    """Return the folder with ``bin`` and ``lib``.

    Raises
    ------
    RadianceError
        If ``pyradiance`` is not installed.
    """
    found = find_folder()
    if found is None:
        raise RadianceError("Radiance's programs are not there; pip install 'bsdftree[radiance]' brings them")
    return found


def environment(directories: Directories = ()) -> dict[str, str]:
    """Return the environment of Radiance's programs: theirs first, files also looked for in ``directories``."""
    home = folder()
    raypath = [*(os.fspath(d) for d in directories), os.environ.get("RAYPATH", "."), os.fspath(home / "lib")]
    path = [os.fspath(home / "bin"), os.environ.get("PATH", os.defpath)]
    return os.environ | {"RAYPATH": os.pathsep.join(raypath), "PATH": os.pathsep.join(path)}


def words_of(name: str, *arguments: object) -> list[str]:
    """Return the words that start a program.

    Raises
    ------
    RadianceError
        If there is no such program.
    """
    path = folder() / "bin" / name
    if not path.is_file():
        raise RadianceError(f"pyradiance has no program {name!r} in {path.parent}; pip install --upgrade pyradiance")
    return [os.fspath(path), *map(str, arguments)]


def failure(name: str, code: int, message: bytes) -> RadianceError:
    """Make the error of a program that failed."""
    lines = [line for line in message.decode(errors="replace").splitlines() if "warning" not in line.lower()]
    return RadianceError(f"Radiance's {name} failed with code {code}: {' '.join(lines)[-2000:] or 'it said nothing'}")


def run(
    name: str, *arguments: object, stdin: bytes = b"", directories: Directories = (), seconds: float | None = None
) -> bytes:
    """Return what one of Radiance's programs prints.

    Raises
    ------
    RadianceError
        As :func:`printed`, or if there is no such program.
    """
    return printed(words_of(name, *arguments), stdin=stdin, directories=directories, seconds=seconds)


def printed(
    words: Sequence[str],
    *,
    stdin: bytes = b"",
    directories: Directories = (),
    seconds: float | None = None,
    most: int = 1 << 32,
) -> bytes:
    """Return what a program prints.

    Raises
    ------
    RadianceError
        If it fails, takes longer than ``seconds``, or prints more than ``most`` bytes.
    """
    name = os.path.basename(words[0])
    with tempfile.TemporaryFile() as source, tempfile.TemporaryFile() as messages:
        source.write(stdin)
        source.seek(0)
        try:
            process = subprocess.Popen(
                words, stdin=source, stdout=subprocess.PIPE, stderr=messages, env=environment(directories)
            )
        except OSError as error:
            raise RadianceError(f"cannot start {words[0]}: {error.strerror}") from None
        assert process.stdout is not None
        clock = threading.Timer(seconds if seconds is not None else threading.TIMEOUT_MAX, process.kill)
        clock.daemon = True
        clock.start()
        pieces, n = [], 0
        try:
            while n <= most and (piece := process.stdout.read(min(1 << 20, most + 1 - n))):
                pieces.append(piece)
                n += len(piece)
            if n <= most:
                process.wait()
        finally:
            late = seconds is not None and not clock.is_alive()
            clock.cancel()
            process.kill()
            process.stdout.close()
            process.wait()
        if n > most:
            raise RadianceError(f"{name} printed more than {most >> 20} MiB and was stopped")
        if late:
            raise RadianceError(f"{name} took more than {seconds:g} s and was stopped")
        if process.returncode != 0:
            messages.seek(0)
            raise failure(name, process.returncode, messages.read())
        return b"".join(pieces)
