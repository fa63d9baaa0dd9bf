"""``python -m bsdftree``."""

from bsdftree.cli import main

main(prog_name="bsdftree")
