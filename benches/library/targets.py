"""What is measured, and how good it is meant to be."""

from __future__ import annotations

from typing import NamedTuple


class Target(NamedTuple):
    """A figure, and the least of it (the most, of times and memory): for trees in the L2 cache, and of 2 M leaves."""

    what: str
    unit: str
    small: float | None
    large: float | None
    less_is_better: bool = False

    def is_met(self, value: float, large: bool) -> bool | None:
        """Whether a value is as good as it is meant to be; None if nothing is asked."""
        wanted = self.large if large else self.small
        if wanted is None:
            return None
        return value <= wanted if self.less_is_better else value >= wanted


TARGETS = (
    Target("eval", "M/s", 100, 50),
    Target("sample, pdf, weight", "M/s", 22, 15),
    Target("pdf", "M/s", 30, 30),
    Target("hemispherical", "M/s", 150, 150),
    Target("projected solid angle", "M/s", 50, 50),
    Target("eval, AVX2 alone", "M/s", 100, 50),
    Target("eval, portable", "M/s", 28, 20),
    Target("eval, single calls", "M/s", 18, 10),
    Target("sample, single calls", "M/s", 4, 2.5),
    Target("pdf, single calls", "M/s", None, None),
    Target("hemispherical, single calls", "M/s", None, None),
    Target("eval, two threads", "×", 1.8, 1.8),
    Target("sample, two threads", "×", 1.8, 1.8),
    Target("NumPy: eval", "% of Rust", 70, 70),
    Target("NumPy: sample, pdf, weight", "% of Rust", 70, 70),
    Target("NumPy: pdf", "% of Rust", 70, 70),
    Target("NumPy: hemispherical", "% of Rust", 70, 70),
    Target("NumPy: projected solid angle", "% of Rust", 70, 70),
    Target("all tables", "ms", None, 120, less_is_better=True),
    Target("memory of all tables", "MB", None, 64, less_is_better=True),
    Target("XML", "MB", None, None),
    Target("XML read", "MB/s", 800, 800),
    Target("XML read, cold process", "MB/s", None, 500),
    Target("memory of that by file and tree", "times", None, 1.3, less_is_better=True),
    Target("XML write", "MB/s", 400, 400),
    Target("XML write, values", "M/s", 40, 40),
    Target("Radiance's XML by bsdft", "times", 3, 3),
    Target("Radiance's XML by bsdft packed at 3", "times", 3.5, 3.5),
    Target("Radiance's XML by bsdft packed at 19", "times", 6, 6),
    Target("own XML by bsdft", "times", None, None),
    Target("own XML by bsdft packed at 3", "times", None, None),
    Target("own XML by bsdft packed at 19", "times", None, None),
    Target("bsdft packed at 3, read", "ms", None, None),
    Target("bsdft opened, first value", "µs", 100, 100, less_is_better=True),
    Target("bsdft verified", "ms", None, None),
)
