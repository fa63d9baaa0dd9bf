"""Judge fits: `python -m benches.fit`, from the root of the repository.

All materials by default, as trees, ours and the incumbent's. In development of the fit:

    python -m benches.fit --quick --material ggx sharp     # model values point by point, no trees, seconds
    python -m benches.fit --ours --material ggx            # our trees alone
    python -m benches.fit --incumbent                      # fill the cache with the incumbent's trees
    python -m benches.fit --klems                          # Klems matrices, theirs by bsdf2klems
    python -m benches.fit --list

What takes long (the incumbent's trees, traced films, true means) is kept in $BSDFTREE_BENCH_CACHE.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from . import contender, gonio, judge, picture, report, truths


def main() -> None:
    arguments = _arguments()
    if arguments.list:
        for m in truths.materials():
            print(f"{m.name:22} {m.family:12} rank {m.rank}  {m.note}")
        return
    chosen = truths.find(arguments.material) if arguments.material else truths.materials()
    chosen = [m for m in chosen if arguments.family in (None, m.family)]
    cases = []
    for material in chosen:
        start = time.perf_counter()
        cases.append(case(material, arguments))
        print(report.table(cases[-1:]))
        if arguments.verbose:
            print(report.directions(cases[-1]))
        print(f"  ({material.note}; {time.perf_counter() - start:.0f} s)\n", flush=True)
    print(report.table(cases))
    if arguments.picture:
        picture.draw(cases, arguments.picture)


def case(material: truths.Material, arguments: argparse.Namespace) -> report.Case:
    """Measure a material and judge whoever is asked for."""
    log2_res = arguments.log2_res or (6 if material.rank == 3 else 5)
    scans = gonio.measure(material)
    court = judge.court(material, log2_res, klems=arguments.klems)
    if arguments.quick:
        return report.Case(court, judge.point_by_point(court, _said(_model(scans, arguments))), None)
    ours = incumbent = None
    if not arguments.incumbent:
        ours = judge.in_cells(court, _said(_tree(scans, material, log2_res, arguments)))
    if not arguments.ours:
        folder = truths.cache_folder()
        files = gonio.write(scans, folder / "scans" / material.name, material.name)
        theirs = (
            contender.radiance_klems(files, folder) if arguments.klems else contender.radiance(files, log2_res, folder)
        )
        incumbent = judge.in_cells(court, theirs)
    return report.Case(court, ours, incumbent)


def _model(scans: list[gonio.Scan], arguments: argparse.Namespace) -> contender.Contender:
    return contender.nearest(scans) if arguments.nearest else contender.model(scans)[0]


def _tree(
    scans: list[gonio.Scan], material: truths.Material, log2_res: int, arguments: argparse.Namespace
) -> contender.Contender:
    if arguments.nearest:
        return contender.nearest(scans)
    made = contender.klems if arguments.klems else contender.tree
    return made(scans, material.rank, log2_res)


def _said(judged: contender.Contender) -> contender.Contender:
    """What the fit says of itself, printed."""
    print(judged.note, flush=True)
    return judged


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benches.fit", description="Fits beside pabopto2bsdf.")
    parser.add_argument("--material", nargs="+", metavar="NAME", help="some of the materials (--list)")
    parser.add_argument("--family", choices=list(truths.TARGETS), help="the materials of a family")
    parser.add_argument("--quick", action="store_true", help="our model point by point, without trees")
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--ours", action="store_true", help="our trees alone")
    who.add_argument("--incumbent", action="store_true", help="the incumbent's trees alone")
    parser.add_argument("--nearest", action="store_true", help="nearest readings instead of our fit")
    parser.add_argument(
        "--klems", action="store_true", help="full Klems matrices, ours of the tree, theirs of bsdf2klems"
    )
    parser.add_argument("--log2-res", type=int, help="of trees; 5 for rank 4, 6 for rank 3 by default")
    parser.add_argument("-v", "--verbose", action="store_true", help="the worst directions of each material")
    parser.add_argument("--picture", type=Path, help="where to draw truth and contenders side by side")
    parser.add_argument("--list", action="store_true", help="what materials there are")
    return parser.parse_args()


if __name__ == "__main__":
    main()
