"""What a notebook shows of a BSDF: a table, with a small picture where there is matplotlib; and the viewer."""

from __future__ import annotations

import base64
import io
from html import escape
from typing import TYPE_CHECKING

from bsdftree._component import Matrix, Tree, wrapped
from bsdftree._queries import Queries
from bsdftree._sides import SIDES
from bsdftree._totals import mean_total

if TYPE_CHECKING:
    from bsdftree._viewer import Viewer


class Shown(Queries):
    """A BSDF as notebooks show it."""

    def _repr_png_(self) -> bytes | None:
        """A small picture; none without matplotlib, or if there is nothing to draw."""
        try:
            from bsdftree.plot import thumbnail
        except ModuleNotFoundError as error:
            if error.name != "matplotlib":
                raise
            return None
        if not self.bands:
            return None
        stream = io.BytesIO()
        thumbnail(self).savefig(stream, format="png")  # type: ignore[arg-type]
        return stream.getvalue()

    def _repr_html_(self) -> str:
        """A table of components, and the small picture in it."""
        rows = "".join(self._row(band, key) for band in self.bands for key in self._core.components(band))
        head = "".join(f"<th>{text}</th>" for text in ("band", "component", "light", "kind", "values", "diffuse total"))
        caption = " ".join(filter(None, (self.name, f"({self.manufacturer})" if self.manufacturer else ""))) or "BSDF"
        table = (
            f'<table class="bsdftree"><caption>{escape(caption)}</caption>'
            f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
        )
        png = self._repr_png_()
        if png is None:
            return table
        return f'{table}<img alt="BSDF [1/sr]" src="data:image/png;base64,{base64.b64encode(png).decode()}">'

    def view(self, *, port: int = 0, browser: bool = True) -> Viewer:
        """Look at it in the browser: :func:`bsdftree.view` of this one."""
        from bsdftree._viewer import view

        return view(self, port=port, browser=browser)  # type: ignore[arg-type]

    def _row(self, band: str, key: str) -> str:
        functions = self._core.components(band)[key]
        component: Tree | Matrix = wrapped(functions[0])
        if isinstance(component, Tree):
            kind, n = f"tree, rank {component.rank}, 2^{component.depth} per axis", component.n_leaves
        else:
            kind, n = (
                f"{component.incident_basis}, {' × '.join(map(str, component.values.shape))}",
                component.values.size,
            )
        sides = SIDES[key]
        total = mean_total(self, sides.incident, sides.kind, band)
        color = ", colour" if len(functions) == 3 else ""
        cells = (band, key.replace("_", " "), str(sides), kind + color, f"{n:,}", f"{100 * total:.2f} %")
        return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
