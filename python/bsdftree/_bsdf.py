"""A BSDF: how it is made, what it has, and files of it; what it is asked and what it becomes stand beside this."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from bsdftree import _core
from bsdftree._component import COMPONENTS, Array, Matrix, Tree, wrapped
from bsdftree._conversions import Conversions
from bsdftree._notebook import Shown


class Bsdf(Shown, Conversions):
    """A BSDF: up to four components in one or more spectral bands.

    All queries take arrays of unit vectors of shape (..., 3), broadcast against each other, and are thread-
    safe. The side of the surface that a direction lies on chooses the component: +z is the front, the room. An
    absent transmission is the other one reversed; an absent reflection is black. A direction exactly between
    two cells belongs to the upper one, so normal incidence has one well-defined value.

    Attributes
    ----------
    name, manufacturer : str
        Of the product.
    width, height, thickness : float or None
        Extent of the device along X, Y, Z [m].
    unit : str
        The unit of length in the file: meter, foot, inch, centimeter or millimeter.
    geometry : str or None
        Device geometry in the file, as MGF text.
    properties : dict of str
        What else the file says of the material, such as ``ThermalConductivity``.
    provenance : list of str
        How it was made: comments at the head of the file.
    repairs : list of str
        What :func:`load` had to mend with ``strict=False``, and remarks.
    bands : list of str
        Names of the spectral bands; queries ask ``Visible`` unless told otherwise.
    """

    @classmethod
    def from_trees(cls, trees: Mapping[str, Tree]) -> Bsdf:
        """Make a BSDF of trees.

        Parameters
        ----------
        trees
            From component (``reflection_front``, ``reflection_back``, ``transmission_front``,
            ``transmission_back``; as in WINDOW, front is the outside here) to tree.

        Examples
        --------
        >>> white = Tree.from_grid(np.full((1, 1, 1, 1), 0.8 / np.pi))
        >>> b = Bsdf.from_trees({"reflection_back": white})
        >>> round(float(b.hemispherical([0, 0, 1])), 4)
        0.8
        """
        return cls.from_components(trees)

    @classmethod
    def from_components(cls, components: Mapping[str, Tree | Matrix]) -> Bsdf:
        """Make a BSDF of trees or matrices; as :meth:`from_trees`.

        Examples
        --------
        >>> white = Matrix.from_values(np.full((41, 41), 0.8 / np.pi), "quarter")
        >>> b = Bsdf.from_components({"reflection_back": white})
        >>> round(float(b.hemispherical([0, 0, 1])), 4)
        0.8
        """
        return cls(_core.Bsdf.of_components({key: [component._core] for key, component in components.items()}))

    @classmethod
    def from_function(
        cls,
        function: Callable[[Array, Array], ArrayLike],
        rank: int = 4,
        log2_res: int = 6,
        *,
        tolerance: float = 0.02,
        components: Sequence[str] = COMPONENTS,
        color: bool = False,
    ) -> Bsdf:
        """Make trees of a function, refined where it changes.

        Values are means over cells. Where a cell holds more than half ``tolerance`` of variation, relative to its own
        mean or that of everything, it is split; a scan of 131072 places and of the directions straight through,
        mirrored and back keeps narrow peaks from being missed.

        Parameters
        ----------
        function
            Takes incident and exitant unit vectors, both away from the surface, (n, 3) each, and gives the BSDF [1/sr]
            without cosine, (n,), or with ``color`` CIE X, Y, Z, (n, 3).
        rank
            4, or 3 if the function does not change when both directions are turned about the normal. Then incident
            directions have y = 0, x <= 0.
        log2_res
            At most 2^log2_res cells per axis, 1 to 10.
        tolerance
            Relative L1 error to aim at, in [0, 1).
        components
            What to make: the function is asked for the sides of these only. Black ones are left out.
        color
            Whether the function gives X, Y, Z.

        Raises
        ------
        ValueError
            If an argument is out of its range, or a value negative or not finite.

        Examples
        --------
        >>> b = Bsdf.from_function(lambda i, o: np.full(len(i), 0.2), components=["reflection_back"])
        >>> b.components
        {'reflection_back': <Tree rank 4, 2^0 per axis, 1 leaves>}
        """

        def floats(incident: Array, exitant: Array) -> Array:
            return np.asarray(function(incident, exitant), np.float64)

        return cls(_core.from_callable(floats, rank, log2_res, tolerance, list(components), color))

    @classmethod
    def from_cal(
        cls,
        names: str | Sequence[str],
        *,
        files: Sequence[str | os.PathLike[str]] = (),
        definitions: Sequence[str] = (),
        rank: int = 4,
        log2_res: int = 6,
        tolerance: float = 0.02,
        components: Sequence[str] = COMPONENTS,
    ) -> Bsdf:
        """Make trees of a function in Radiance's function language, as bsdf2ttree does.

        Parameters
        ----------
        names
            A function of six arguments: the incident, then the exitant unit vector, both away from the surface. Its
            value is the BSDF [1/sr] without cosine. Or three of them: Radiance's red, green and blue.
        files, definitions
            Function files and definitions such as ``"s = 0.1;"``, in this order.
        rank, log2_res, tolerance, components
            As in :meth:`from_function`.

        Raises
        ------
        ValueError
            If a text is not understood, with its line, or as :meth:`from_function`.
        OSError
            If a file cannot be read.

        Examples
        --------
        >>> b = Bsdf.from_cal("f", definitions=["f(ix,iy,iz,ox,oy,oz) = if(oz * iz, 0.2, 0);"])
        >>> list(b.components)
        ['reflection_back', 'reflection_front']
        """
        names = [names] if isinstance(names, str) else list(names)
        texts = [os.fspath(path) for path in files]
        return cls(_core.from_cal(names, texts, list(definitions), rank, log2_res, tolerance, list(components)))

    @property
    def components(self) -> dict[str, Tree | Matrix]:
        """Luminance of each component of the band ``Visible`` (or the only band), by name."""
        return self.components_of(self.bands[0] if "Visible" not in self.bands and self.bands else "Visible")

    def components_of(self, band: str) -> dict[str, Tree | Matrix]:
        """Luminance of each component of a band, by name."""
        return {key: wrapped(functions[0]) for key, functions in self._core.components(band).items()}

    def chroma_of(self, band: str = "Visible") -> dict[str, tuple[Tree | Matrix, Tree | Matrix]]:
        """Colour of the components that have it: u′ and v′ trees, or X and Z matrices."""
        components = self._core.components(band)
        return {key: (wrapped(f[1]), wrapped(f[2])) for key, f in components.items() if len(f) == 3}

    @property
    def is_smooth(self) -> bool:
        """Whether there are ramps in the leaves of its trees: :meth:`smooth`."""
        return self._core.is_smooth

    def distance(self, other: Bsdf, band: str = "Visible") -> dict[str, float]:
        """How far another BSDF is from this one, of whatever kind they are.

        Parameters
        ----------
        other
            The other BSDF, such as this one converted.
        band
            Spectral band.

        Returns
        -------
        dict of float
            For each component that both have: the integral of abs(a - b) by that of a, over incident and exitant
            projected solid angle, to about 1 % of the result. 0 is no difference, 2 nothing in common.
        """
        ours, theirs = self.components_of(band), other.components_of(band)
        return {
            key: _core.relative_l1(component._core, theirs[key]._core)
            for key, component in ours.items()
            if key in theirs
        }

    def to_xml(self) -> str:
        """Return the BSDF as WINDOW 6 XML."""
        return self._core.to_xml()

    def save(self, path: str | os.PathLike[str], *, packed: bool = False, level: int = 19) -> None:
        """Write the BSDF, replacing the file only when it is complete.

        Parameters
        ----------
        path
            If it ends in ``.bsdft``, the binary twin of the XML is written, which holds the same to the last bit; else
            WINDOW 6 XML.
        packed
            Compress a ``.bsdft`` file. It is smaller, but read as a whole, while others are opened at once, whatever
            their size.
        level
            Of the compression, from 1 (fast) to 22 (small).

        Raises
        ------
        OSError
            If it cannot be written.
        ValueError
            If XML is to be packed, or there is no such level.
        """
        self._core.write(os.fspath(path), level if packed else None)

    def verify(self) -> None:
        """Look through all values of a ``.bsdft`` file, which :func:`load` does not do.

        Raises
        ------
        ValueError
            If the file is damaged; the message says where. Queries of it are safe, but their answers are worth nothing.
        """
        self._core.verify()

    def __repr__(self) -> str:
        parts = ", ".join(f"{key}: {component!r}" for key, component in self.components.items()) if self.bands else ""
        return f"<Bsdf {self.name!r} bands {', '.join(self.bands)}; {parts}>"


def load(path: str | os.PathLike[str], strict: bool = True) -> Bsdf:
    """Read a BSDF, tensor trees or Klems matrices, from WINDOW 6 XML or its binary twin, ``.bsdft``.

    Parameters
    ----------
    path
        The file; its first bytes say what it is. A ``.bsdft`` file that is not packed is mapped: it is open at once
        whatever its size, must not be changed while it is in use, and :meth:`Bsdf.verify` looks through it.
    strict
        Whether to refuse what would be lost or reinterpreted silently. Otherwise it is mended, and ``repairs`` of the
        result says what was done.

    Raises
    ------
    ValueError
        If it is not a BSDF; the message has byte offset, line, what was found and what was expected.
    OSError
        If it cannot be read.
    """
    return Bsdf(_core.Bsdf.read(os.fspath(path), strict))
