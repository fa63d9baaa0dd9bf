"""Progress on standard error."""

from __future__ import annotations

import time
from collections.abc import Callable

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from bsdftree.cli._common import stderr


class WorkBar:
    """A progress bar with rate and time left, shown on terminals if the work takes long.

    Parameters
    ----------
    doing, after
        What is done, and what once all is counted.
    rate
        The text of a rate [1/s].
    patience
        For how long nothing is shown [s].
    """

    def __init__(self, doing: str, after: str, rate: Callable[[float], str], patience: float = 1.0) -> None:
        self._doing, self._after, self._rate, self._patience = doing, after, rate, patience
        self._progress: Progress | None = None
        self._begin = time.perf_counter()

    def __enter__(self) -> WorkBar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._progress is not None:
            self._progress.stop()

    def update(self, done: int, total: int) -> None:
        """Show how much is done of what is to do; nothing is known of a total of 0."""
        elapsed = time.perf_counter() - self._begin
        if self._progress is None:
            if elapsed < self._patience or total == 0 or not stderr.is_terminal:
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
            self._task = self._progress.add_task(self._doing, total=total, rate="")
        if done < total:
            self._progress.update(self._task, completed=done, rate=self._rate(done / elapsed))
        else:
            self._progress.update(self._task, completed=done, description=self._after)


def paths_bar() -> WorkBar:
    """Of path tracing."""
    return WorkBar("tracing", "reducing", lambda rate: f"{rate / 1e6:.2f} M paths/s")


def fits_bar() -> WorkBar:
    """Of fits, counted by cross-validation."""
    doing = "trying how scans are best predicted from each other"
    return WorkBar(doing, "fitting totals", lambda rate: f"{rate:.1f} tries/s")


def cells_bar() -> WorkBar:
    """Of trees from fits, counted by incident cell."""
    return WorkBar("trees", "errors", lambda rate: f"{rate:,.0f} incident cells/s", patience=2.0)
