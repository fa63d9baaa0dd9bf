"""Three devices, from geometry to a BSDF that Radiance accepts: XML, a picture and a line of figures for each.

The devices of the talk "A Variable-resolution BSDF Implementation" (G. Ward, A. McNeil): a mirror as an
isotropic tree, and a sawtooth of alternating diffuse and mirror facets; and a venetian blind.

    python examples/demo.py OUTPUT_FOLDER
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pyradiance
from rich.console import Console
from rich.table import Table

import bsdftree
from bsdftree import plot
from bsdftree._totals import mean_total
from bsdftree.cli._progress import PathsBar

DEVICES = {
    "mirror": ("mirror", {"rank": 3, "log2_res": 4}),
    "sawtooth": ("sawtooth", {"rank": 4, "log2_res": 5, "tile": True}),
    "blinds": ("blinds:depth=0.05,spacing=0.04,angle=30", {"rank": 4, "log2_res": 5, "tile": True}),
}


def main(folder: Path) -> None:
    """Generate everything into ``folder`` and print the table."""
    folder.mkdir(parents=True, exist_ok=True)
    console = Console(width=None if sys.stdout.isatty() else 110)
    table = Table(title="From device geometry to BSDF", title_justify="left", box=None, pad_edge=False)
    for column in (
        "device",
        "tree",
        "R front",
        "T front",
        "R back",
        "T back",
        "leaves",
        "bytes",
        "paths",
        "paths/s",
        "s",
    ):
        table.add_column(column, justify="left" if column in ("device", "tree") else "right", no_wrap=True)
    for name, (spec, options) in DEVICES.items():
        xml, png = folder / f"{name}.xml", folder / f"{name}.png"
        reports: list[bsdftree.GenerationReport] = []
        begin = time.perf_counter()
        with PathsBar() as bar:
            made = bsdftree.generate(spec, **options, progress=bar.update, report=reports.append)
        made.with_header(name=name).save(xml)
        seconds = time.perf_counter() - begin
        bsdf = bsdftree.load(xml)
        plot.overview(bsdf, title=name).savefig(png)
        leaves = sum(tree.n_leaves for tree in bsdf.components.values())
        totals = [mean_total(bsdf, side, part) for side in (1, -1) for part in ("reflection", "transmission")]
        table.add_row(
            name,
            f"rank {options['rank']}, 2^{options['log2_res']}",
            *(f"{100 * t:.1f} %" for t in totals),
            f"{leaves:,}",
            f"{xml.stat().st_size:,}",
            f"{reports[0].paths:,}",
            f"{reports[0].paths / reports[0].tracing_seconds / 1e6:.2f} M",
            f"{seconds:.2f}",
        )
    console.print(table)
    check_bsdf = Path(pyradiance.__file__).parent / "bin" / "checkBSDF"
    for name in DEVICES:
        result = subprocess.run([check_bsdf, folder / f"{name}.xml"], capture_output=True, text=True, check=False)
        verdict = "accepts" if result.returncode == 0 and not result.stderr else f"refuses ({result.stderr.strip()})"
        console.print(
            f"Radiance's checkBSDF {verdict} {folder / name}.xml; picture in {folder / name}.png", highlight=False
        )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "demo"))
