"""Print all tables as Markdown: `python -m benches.generate [--quick]`, from the root of the repository.

References are kept in --cache (or BSDFTREE_BENCH_CACHE), so that a second run has them; by default they are made anew
in a temporary folder.
"""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import bsdftree

from . import comparisons, equal_error, raw_speed, resolution, talk

SECTIONS = ("speed", "talk", "equal-error", "resolution")
PICTURE = Path("docs/img/resolution.png")


def main() -> None:
    arguments = _arguments()
    began = time.perf_counter()
    print("# Generation\n")
    print(
        f"{cpu_name()}, {os.cpu_count()} threads; load {os.getloadavg()[0]:.1f}; Python {platform.python_version()}, "
        f"bsdftree {bsdftree.__version__}, pyradiance {version('pyradiance')}"
    )
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary)
        cache = arguments.cache or work / "references"
        if "speed" in arguments.only:
            raw_speed.run(arguments.quick, work)
        if "talk" in arguments.only:
            talk.run(arguments.quick, work)
        if "equal-error" in arguments.only:
            measured = equal_error.measurements(arguments.quick, cache, work, arguments.device)
            print("\n## Equal error")
            comparisons.print_tables(measured)
        if "resolution" in arguments.only:
            picture = work / "resolution.png" if arguments.quick and not arguments.picture else arguments.picture
            resolution.run(arguments.quick, work, picture or PICTURE)
    print(f"\n{(time.perf_counter() - began) / 60:.1f} minutes; load at the end {os.getloadavg()[0]:.1f}.")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benches.generate", description="Equal-error benchmarks of generation."
    )
    parser.add_argument("--quick", action="store_true", help="three minutes instead of forty: coarse, few samples")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=SECTIONS, help="some of the sections")
    parser.add_argument(
        "--device", nargs="+", metavar="NAME", default=(), help="some of the devices of equal-error, e.g. blinds"
    )
    parser.add_argument("--picture", type=Path, help=f"where to draw the resolution sweep; {PICTURE} by default")
    cache = os.environ.get("BSDFTREE_BENCH_CACHE")
    parser.add_argument(
        "--cache",
        type=Path,
        default=Path(cache) if cache else None,
        help="folder that keeps references (BSDFTREE_BENCH_CACHE); a temporary one by default",
    )
    return parser.parse_args()


def cpu_name() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


if __name__ == "__main__":
    main()
