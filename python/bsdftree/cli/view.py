"""``bsdftree view``: look at BSDFs in the browser."""

from __future__ import annotations

import click

from bsdftree._viewer import Viewer, write_view
from bsdftree._viewer.built import page_files
from bsdftree._viewer.exhibit import exhibits
from bsdftree.cli._common import say_repairs, with_input_errors


@click.command()
@click.argument("files", nargs=-1, metavar="[FILE]...", type=click.Path())
@click.option(
    "--export", "exported", metavar="OUT.html", type=click.Path(), help="Write one file with all in it instead."
)
@click.option("--port", type=click.IntRange(1, 65535), help="Where to listen. [default: any that is free]")
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@with_input_errors
def view(files: tuple[str, ...], exported: str | None, port: int | None, no_browser: bool) -> None:
    """Look at BSDFs in the browser: lobes, polar maps, slices, totals, the whole function, the tree; two side by side.

    The viewer is served to this machine alone (127.0.0.1) until Ctrl-C, and reads nothing but the files given. More can
    be dropped on it. When a file has changed, load the page again.

    With --export, one HTML file is written that holds the viewer and the BSDFs: it opens anywhere by a double click,
    without a server or a network.

    \b
    Examples:
      bsdftree view blinds.xml
      bsdftree view blinds.xml small.xml                   side by side
      bsdftree view film.xml film_errors.xml               with what fit --errors wrote
      bsdftree view blinds.xml --export blinds.html        to send to somebody
      bsdftree view blinds.xml --no-browser --port 8000    on a remote machine, behind ssh -L 8000:127.0.0.1:8000
    """
    if exported and (port or no_browser):
        raise click.UsageError("--export writes a file: there is nothing to serve at --port, nor to open")
    page_files()
    shown = exhibits(files)
    for file in shown:
        say_repairs(file.name, file.repairs)
    if exported:
        write_view(exported, shown)
        click.echo(f"wrote {exported}", err=True)
        return
    try:
        with Viewer(shown, port or 0) as viewer:
            click.echo(viewer.url)
            if not no_browser and not viewer.open():
                click.echo("bsdftree: no browser opened; open the address by hand", err=True)
            click.echo("Ctrl-C ends it", err=True)
            viewer.wait()
    except KeyboardInterrupt:
        click.echo(err=True)
