"""A scene as one text that Radiance's programs can read without running anything.

In: Radiance scene files, or text. Out: the text of all, in their order, with what each ``!`` command prints in its
place. Radiance gives such commands, and names that begin with ``!``, to a shell; here programs are started by name:
``xform``, ``cat`` and Radiance's generators, others only if they were allowed; pipes are understood, and nothing else
of the shell. Octrees of ``instance`` must be frozen: others name files, which may be commands.

Files that a command names are looked for beside the file that names them, then in the working directory, then in
``RAYPATH``. Bounded: files and commands inside each other, bytes, and seconds of a program.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from bsdftree._radiance.programs import RadianceError, printed, words_of

GENERATORS = frozenset(
    ["genblinds", "genbox", "genprism", "genrev", "gensurf", "genworm", "replmarks", "gensky", "gendaylit"]
)
DEEPEST = 32
MOST_BYTES = 1 << 30
SECONDS = 60.0
SHELL = "|;&<>`$()*?[\\"

# What xform takes with each option; files follow the options.
_XFORM = {"-t": 3, "-s": 1, "-rx": 1, "-ry": 1, "-rz": 1, "-a": 1, "-i": 1, "-n": 1, "-m": 1, "-f": 1}
_XFORM |= dict.fromkeys(["-mx", "-my", "-mz", "-e", "-c", "-I"], 0)


@dataclass
class SceneText:
    """A scene for Radiance's programs.

    Attributes
    ----------
    text
        Without commands.
    directories
        Where its function files and pictures are looked for, besides ``RAYPATH``.
    """

    text: bytes
    directories: list[str] = field(default_factory=list)


def scene_of_files(paths: Sequence[str | os.PathLike[str]], allow_commands: Collection[str] = ()) -> SceneText:
    """Read files as one scene.

    Raises
    ------
    RadianceError
        If a file cannot be read, is no scene, or asks for a program that is not allowed; with file and line.
    """
    reader = _Reader(frozenset(allow_commands))
    pieces = [reader.file(Path(path), None, 0) for path in paths]
    return SceneText(b"\n".join(pieces), list(dict.fromkeys(str(Path(path).parent) for path in paths)))


def scene_of_text(text: str | bytes, allow_commands: Collection[str] = (), name: str = "text") -> SceneText:
    """Take text as a scene; files that it names are looked for in the working directory."""
    data = text.encode() if isinstance(text, str) else text
    return SceneText(_Reader(frozenset(allow_commands)).text(data.decode("latin-1"), name, Path("."), 0))


class _Reader:
    def __init__(self, allowed: frozenset[str]) -> None:
        self.allowed = allowed
        self.left = MOST_BYTES

    def file(self, path: Path, named_at: str | None, depth: int) -> bytes:
        at = f"{named_at}: " if named_at else ""
        if depth > DEEPEST:
            raise RadianceError(f"{at}files and commands are more than {DEEPEST} deep; does {path} name itself?")
        try:
            if not path.is_file():
                raise RadianceError(f"{at}{path}: no such file")
            data = path.read_bytes()
        except OSError as error:
            raise RadianceError(f"{at}{path}: {error.strerror}") from None
        return self.text(data.decode("latin-1"), str(path), path.parent, depth)

    def text(self, text: str, name: str, directory: Path, depth: int) -> bytes:
        pieces = []
        for statement in _statements(text, name):
            if isinstance(statement, _Command):
                pieces.append(self.command(statement, directory, depth))
            else:
                pieces.append(statement.encode("latin-1"))
        result = b"\n".join(pieces) + b"\n"
        self.left -= len(result)
        if self.left < 0:
            raise RadianceError(f"{name}: the scene expands to more than {MOST_BYTES >> 20} MiB")
        return result

    def command(self, command: _Command, directory: Path, depth: int) -> bytes:
        output = b""
        for k, words in enumerate(_pipe(command)):
            output = self.program(words, output, command.at, directory, depth, first=k == 0)
        # What a program prints may hold commands again.
        return self.text(output.decode("latin-1"), command.at, directory, depth + 1)

    def program(self, words: list[str], stdin: bytes, at: str, directory: Path, depth: int, *, first: bool) -> bytes:
        name, *arguments = words
        for word in arguments:
            if word.startswith("!"):
                raise RadianceError(f"{at}: {name} is given the command {word!r}, which is not run")
        if name in ("xform", "cat"):
            n = len(arguments) if name == "cat" else _n_options(arguments, at)
            options, files = ([], arguments) if name == "cat" else (arguments[:n], arguments[n:])
            if files:
                found = [self.find(file, directory, at) for file in files]
                stdin = b"\n".join(self.file(path, at, depth + 1) for path in found)
            elif first:
                raise RadianceError(f"{at}: {name} names no file; expected the files that it is to read")
            else:
                # From the program before: its commands are done before they are transformed.
                stdin = self.text(stdin.decode("latin-1"), at, directory, depth + 1)
            if name == "cat":
                return stdin
            started = words_of("xform", *options)
        elif name in GENERATORS:
            started = words_of(name, *arguments)
        elif name in self.allowed:
            path = shutil.which(name)
            if path is None:
                raise RadianceError(f"{at}: the allowed command {name!r} is not there")
            started = [path, *arguments]
        else:
            raise RadianceError(
                f"{at}: the command {name!r} is not run; put what it prints into a file and name that, or allow it "
                f"(--allow-command {name})"
            )
        try:
            return printed(started, stdin=stdin, directories=[str(directory)], seconds=SECONDS, most=MOST_BYTES)
        except RadianceError as error:
            raise RadianceError(f"{at}: {error}") from None

    def find(self, name: str, directory: Path, at: str) -> Path:
        for folder in [directory, Path(), *map(Path, os.environ.get("RAYPATH", "").split(os.pathsep))]:
            if (folder / name).is_file():
                return folder / name
        raise RadianceError(f"{at}: no file {name!r}, looked for in {directory}, the working directory and RAYPATH")


@dataclass
class _Command:
    line: str
    at: str


def _statements(text: str, name: str) -> list[str | _Command]:
    """Cut a scene into primitives, as they stand, and commands; comments are left out."""
    statements: list[str | _Command] = []
    words = _Words(text, name)
    while (c := words.skip()) != "":
        start = words.position
        if c == "#":
            words.line()
        elif c == "!":
            at = words.at()
            statements.append(_Command(words.line()[1:], at))
        else:
            words.primitive()
            statements.append(text[start : words.position])
    return statements


class _Words:
    """Words of a scene, as Radiance reads them."""

    def __init__(self, text: str, name: str) -> None:
        self.text, self.name, self.position = text, name, 0

    def at(self) -> str:
        return f"{self.name}:{self.text.count(chr(10), 0, self.position) + 1}"

    def skip(self) -> str:
        while self.position < len(self.text) and self.text[self.position].isspace():
            self.position += 1
        return self.text[self.position : self.position + 1]

    def line(self) -> str:
        """Return the rest of the line and those that it goes on in."""
        start = self.position
        while True:
            end = self.text.find("\n", self.position)
            self.position = len(self.text) if end < 0 else end + 1
            if end < 0 or end == start or self.text[end - 1] != "\\" or self.text[start] != "!":
                return self.text[start : self.position].replace("\\\n", " ").strip()

    def word(self, expected: str) -> str:
        c = self.skip()
        if c == "":
            raise RadianceError(f"{self.at()}: the scene ends; expected {expected}")
        start = self.position
        if c in "\"'":
            end = self.text.find(c, start + 1)
            self.position = len(self.text) if end < 0 else end + 1
            return self.text[start + 1 : end if end >= 0 else None]
        while self.position < len(self.text) and not self.text[self.position].isspace():
            self.position += 1
        return self.text[start : self.position]

    def count(self, what: str) -> int:
        word = self.word(f"the number of {what} arguments")
        if not word.isascii() or not word.isdigit() or int(word) > len(self.text):
            raise RadianceError(f"{self.at()}: {word!r} for the number of {what} arguments; expected a small integer")
        return int(word)

    def primitive(self) -> None:
        at = self.at()
        _, kind, name = (self.word(what) for what in ("a modifier", "a type", "a name"))
        if kind == "alias":
            self.word("what the alias stands for")
            return
        strings = [self.word("a string argument") for _ in range(self.count("string"))]
        for kind_of in ("integer", "real"):
            for _ in range(self.count(kind_of)):
                self.word(f"{kind_of} arguments of {kind} {name}")
        for string in strings:
            if string.startswith("!"):
                raise RadianceError(
                    f"{at}: {kind} {name} names the command {string!r}, which is not run; put what it prints into a "
                    f"file and name that"
                )
        if kind == "instance" and strings:
            _check_octree(strings[0], Path(self.name).parent, at)


def _check_octree(name: str, directory: Path, at: str) -> None:
    """Refuse octrees that name scene files, which Radiance would open, and run if they begin with ``!``."""
    folders = [directory, Path(), *map(Path, os.environ.get("RAYPATH", "").split(os.pathsep))]
    path = next((folder / name for folder in folders if (folder / name).is_file()), None)
    if path is None:
        raise RadianceError(f"{at}: no octree {name!r}")
    data = path.read_bytes()[: 1 << 20]
    body = data[data.find(b"\n\n") + 4 :]
    # Centre and size are four strings; then come the names of files, none in a frozen octree.
    fields = body.split(b"\0", 5)
    if not data.startswith(b"#?") or len(fields) < 6 or fields[4] != b"":
        raise RadianceError(f"{at}: the octree {path} is not frozen; make it with oconv -f")


def _n_options(arguments: Sequence[str], at: str) -> int:
    """Count the words of xform's arguments before its files."""
    n = 0
    while n < len(arguments) and arguments[n].startswith("-"):
        if arguments[n] not in _XFORM:
            raise RadianceError(f"{at}: xform has no option {arguments[n]!r}")
        n += 1 + _XFORM[arguments[n]]
    return min(n, len(arguments))


def _pipe(command: _Command) -> list[list[str]]:
    """Split a command line into programs and their words."""
    programs: list[list[str]] = [[]]
    word: str | None = None
    quote = ""
    for c in command.line + " ":
        if quote and c == quote:
            quote = ""
        elif quote or (not c.isspace() and c not in SHELL + "\"'"):
            word = (word or "") + c
        elif c in "\"'":
            quote, word = c, word or ""
        elif c.isspace() or c == "|":
            if word is not None:
                programs[-1].append(word)
                word = None
            if c == "|":
                programs.append([])
        else:
            raise RadianceError(f"{command.at}: {c!r} in a command; no shell is run: write plain words or quote it")
    if quote:
        raise RadianceError(f"{command.at}: a quote in the command is not closed")
    if not all(programs) or len(programs) > DEEPEST:
        raise RadianceError(f"{command.at}: a command of {len(programs)} programs; expected a word after '!' and '|'")
    return programs
