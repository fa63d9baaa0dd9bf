"""What a program costs: wall time, CPU time and memory of a process and of those that it starts and waits for.

A process inherits the high-water mark of the memory of the process that it was forked from. So this file, run as a
script, stands between, as a small process that starts the program and says what it cost.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Cost:
    """Wall and CPU (user + system) time [s], largest resident memory of a single process [byte]."""

    wall: float = 0.0
    cpu: float = 0.0
    memory: int = 0

    def __add__(self, other: Cost) -> Cost:
        """Of two programs, one after the other."""
        return Cost(self.wall + other.wall, self.cpu + other.cpu, max(self.memory, other.memory))


def run(
    command: Sequence[object],
    *,
    stdin: Path | None = None,
    stdout: Path | None = None,
    environment: dict[str, str] | None = None,
) -> Cost:
    """Run a program to its end; its message is the error, if it fails."""
    words = [str(word) for word in command]
    with (
        open(stdin or os.devnull, "rb") as source,
        open(stdout or os.devnull, "wb") as sink,
        tempfile.NamedTemporaryFile() as cost,
    ):
        between = [sys.executable, "-I", __file__, cost.name, *words]
        done = subprocess.run(between, stdin=source, stdout=sink, stderr=subprocess.PIPE, env=environment)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(words)}: {done.returncode}\n{done.stderr.decode(errors='replace')}")
        return Cost(**json.load(cost))


def _between(into: str, *command: str) -> int:
    start = time.perf_counter()
    child = os.posix_spawnp(command[0], command, os.environ)
    _, status, usage = os.wait4(child, 0)
    cost = Cost(time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024)
    Path(into).write_text(json.dumps(vars(cost)))
    return os.waitstatus_to_exitcode(status)


if __name__ == "__main__":
    sys.exit(_between(*sys.argv[1:]))
