"""The command line: one file per verb."""

from __future__ import annotations

import click

from bsdftree import __version__
from bsdftree.cli.check import check
from bsdftree.cli.convert import convert
from bsdftree.cli.eval import eval_
from bsdftree.cli.fit import fit
from bsdftree.cli.from_function import from_function
from bsdftree.cli.genbsdf import genbsdf
from bsdftree.cli.generate import generate
from bsdftree.cli.info import info
from bsdftree.cli.lobes import lobes
from bsdftree.cli.measured import measured
from bsdftree.cli.merge import merge
from bsdftree.cli.package import package
from bsdftree.cli.plot import plot
from bsdftree.cli.reduce import reduce
from bsdftree.cli.stack import stack
from bsdftree.cli.view import view

_CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


@click.group(context_settings=_CONTEXT)
@click.version_option(__version__, prog_name="bsdftree")
def main() -> None:
    """Variable-resolution BSDFs: make them from device geometry, look into them, check and draw them.

    \b
    Typical use:
      bsdftree generate blinds.rad -o blinds.xml      device geometry to BSDF
      bsdftree genbsdf -t4 5 blinds.rad > blinds.xml  the same by Radiance's command line
      bsdftree measured film_*.txt                    what a goniophotometer measured
      bsdftree fit film_*.txt -o film.xml             measurements to BSDF
      bsdftree info blinds.xml                        what is in it
      bsdftree check blinds.xml                       does it obey physics
      bsdftree plot blinds.xml -o blinds.png          see it
      bsdftree view blinds.xml                        look round in it, in the browser
      bsdftree convert blinds.xml blinds.bsdft        write it in another format
      bsdftree reduce blinds.xml -o small.xml         make it smaller, to an error that you choose
      bsdftree package blinds.xml -o objects          put it into a Radiance scene

    Data goes to standard output or to -o, progress to standard error. Exit code 0: done; 1: the input is bad
    (or a check is violated); 2: the command line is not understood.
    """


for _verb in (
    generate,
    genbsdf,
    info,
    check,
    eval_,
    plot,
    view,
    lobes,
    from_function,
    measured,
    fit,
    merge,
    stack,
    convert,
    reduce,
    package,
):
    main.add_command(_verb)
