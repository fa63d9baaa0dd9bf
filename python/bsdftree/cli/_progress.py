"""Progress of path tracing on standard error."""

from __future__ import annotations

import time

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from bsdftree.cli._common import stderr


class PathsBar:
    """A progress bar with rate and time left, shown if the work takes over a second."""

    def __init__(self) -> None:
        self._progress: Progress | None = None
        self._begin = time.perf_counter()

    def __enter__(self) -> PathsBar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._progress is not None:
            self._progress.stop()

    def update(self, done: int, total: int) -> None:
        """Show paths done of paths to do."""
        elapsed = time.perf_counter() - self._begin
        if self._progress is None:
            if elapsed < 1.0 or total == 0 or not stderr.is_terminal:
                return
            self._progress = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                TextColumn("{task.percentage:>3.0f} %  {task.fields[rate]}"),
                TimeElapsedColumn(),
                TextColumn("left"),
                TimeRemainingColumn(),
                console=stderr,
                transient=True,
            )
            self._progress.start()
            self._task = self._progress.add_task("tracing", total=total, rate="")
        if done < total:
            self._progress.update(self._task, completed=done, rate=f"{done / elapsed / 1e6:.2f} M paths/s")
        else:
            self._progress.update(self._task, completed=done, description="reducing")
