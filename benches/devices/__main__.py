"""Compare all devices and write the report: `python -m benches.devices [NAME…]`, from the root of the repository."""

from __future__ import annotations

import argparse
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from . import picture, report
from .real import real
from .run import Measured, measure
from .scenes import own

SAMPLES = 16384
REPORT = Path("docs/devices.md")
PICTURE = Path("img/devices.png")
"""From the report."""


def main() -> None:
    arguments = _arguments()
    scenes = [s for s in own() + real() if not arguments.names or s.name in arguments.names]
    missing = set(arguments.names) - {s.name for s in scenes}
    if missing:
        sys.exit(f"no such device: {', '.join(sorted(missing))}; there are {', '.join(s.name for s in own() + real())}")
    began = time.perf_counter()
    measured: list[Measured] = []
    with ProcessPoolExecutor(arguments.processes) as pool:
        for m in pool.map(partial(measure, samples=arguments.samples), scenes):
            measured.append(m)
            v = m.verdict
            print(
                f"{m.scene.name:24} {report.verdict(m):16} p {v.p:.1e} ({v.worst}), totals within "
                f"{100 * v.largest_difference:.2f} points",
                flush=True,
            )
    minutes = (time.perf_counter() - began) / 60
    if not arguments.names or arguments.output != REPORT:
        picture.draw(measured, arguments.output.parent / PICTURE)
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        arguments.output.write_text(report.text(measured, arguments.samples, minutes, PICTURE))
        print(f"{arguments.output}: {minutes:.1f} minutes")
    if any(not m.verdict.agrees and not m.scene.known for m in measured):
        sys.exit(1)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benches.devices", description="Our engine beside Radiance.")
    parser.add_argument("names", nargs="*", help="files of devices; all of them by default")
    parser.add_argument("--samples", type=int, default=SAMPLES, help="rays for each side and incident patch")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), help="devices at once")
    parser.add_argument("-o", "--output", type=Path, default=REPORT, help="report; not written for some devices alone")
    return parser.parse_args()


if __name__ == "__main__":
    main()
