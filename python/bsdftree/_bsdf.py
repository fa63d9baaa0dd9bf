"""A BSDF and what can be asked of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bsdftree import _core
from bsdftree._check import KINDS, Check, Mended, check_of
from bsdftree._directions import as_pairs, as_rows
from bsdftree._peaks import PeakFamily, peak_families

COMPONENTS = ("reflection_front", "reflection_back", "transmission_front", "transmission_back")
"""All components; front is the outside here, as in WINDOW."""

Part = Literal["all", "reflection", "transmission"]
Array = NDArray[np.float64]


class Sample(NamedTuple):
    """Directions sampled from a BSDF.

    Attributes
    ----------
    exitant
        Unit vectors, (..., 3). Meaningless where ``pdf`` is 0.
    weight
        BSDF x |cos θ_exitant| / pdf, (...), or as X, Y, Z (..., 3); 0 where the BSDF is black.
    pdf
        Density of ``exitant`` [1/sr of solid angle], (...).
    """

    exitant: Array
    weight: Array
    pdf: Array


class Tree:
    """A tensor tree: one BSDF component, subdivided where it changes.

    Attributes
    ----------
    rank : int
        3 (isotropic: incident polar angle, exitant direction) or 4.
    depth : int
        Deepest subdivision: 2^depth cells per axis.
    n_leaves : int
        Number of values.
    nbytes : int
        Memory of the tree [byte].
    """

    def __init__(self, core: _core.Tree) -> None:
        self._core = core
        self.rank = core.rank
        self.depth = core.depth
        self.n_leaves = core.n_leaves
        self.nbytes = core.nbytes

    @classmethod
    def from_grid(cls, values: ArrayLike) -> Tree:
        """Build a tree from a uniform grid; equal neighbours become one leaf.

        Parameters
        ----------
        values
            BSDF [1/sr], shape (2^N,) * rank with rank 3 or 4. Axes as in the file format: rank 4 is incident x, y and
            exitant x, y of the Shirley-Chiu square; rank 3 is incident polar angle and exitant x, y.

        Raises
        ------
        ValueError
            If the shape is not that, or a value is negative or not finite.

        Examples
        --------
        >>> Tree.from_grid(np.full((4, 4, 4, 4), 0.2)).n_leaves
        1
        """
        array = np.asarray(values, np.float32)
        if array.ndim not in (3, 4) or len(set(array.shape)) != 1:
            raise ValueError(f"a grid of shape {array.shape}; expected (2^N,) * 3 or (2^N,) * 4")
        return cls(_core.Tree._from_grid(np.ascontiguousarray(array).reshape(-1), array.ndim))

    @classmethod
    def from_raw(cls, values: bytes | ArrayLike, rank: int = 4) -> Tree:
        """Build a tree from what rttree_reduce reads: all values of a uniform grid, one after the other.

        Parameters
        ----------
        values
            Bytes of 32-bit floats (``-ff``), or numbers, such as ``np.loadtxt(path)`` of a text file (``-fa``). The
            last axis varies fastest.
        rank
            3 or 4.

        Raises
        ------
        ValueError
            If there are not (2^N)^rank of them.

        Examples
        --------
        >>> Tree.from_raw(np.full(256, 0.2, np.float32).tobytes()).n_leaves
        1
        """
        array = np.frombuffer(values, np.float32) if isinstance(values, bytes) else np.asarray(values, np.float32)
        n = round(array.size ** (1 / rank)) if rank in (3, 4) else 0
        if not n or n**rank != array.size:
            raise ValueError(f"{array.size} values; expected (2^N)^{rank}, with rank 3 or 4")
        return cls.from_grid(array.reshape((n,) * rank))

    def to_grid(self, log2_res: int | None = None) -> NDArray[np.float32]:
        """Values on a uniform grid.

        Parameters
        ----------
        log2_res
            2^log2_res cells per axis; the tree's own depth by default. Coarser cells are means.

        Returns
        -------
        ndarray
            Shape (2^log2_res,) * rank [1/sr].

        Raises
        ------
        ValueError
            If the grid would have over 2^31 values.
        """
        log2_res = self.depth if log2_res is None else log2_res
        if not 0 <= log2_res * self.rank <= 31:
            raise ValueError(f"a grid of 2^{log2_res} cells along {self.rank} axes; expected at most 2^31 in all")
        return self._core._to_grid(log2_res).reshape((1 << log2_res,) * self.rank)

    def leaves(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32], NDArray[np.float32]]:
        """All leaves.

        Returns
        -------
        cells : ndarray
            Lower corners in units of each leaf's own edge, (n_leaves, rank).
        levels : ndarray
            Edge is 2^-level, (n_leaves,).
        values : ndarray
            [1/sr], (n_leaves,).
        """
        return self._core.leaves()

    def __repr__(self) -> str:
        return repr(self._core)


class Matrix:
    """A Klems matrix: one BSDF component over fixed patches.

    Attributes
    ----------
    values : ndarray
        [1/sr], (incident patches, exitant patches). WINDOW's text has the transpose.
    incident_basis, exitant_basis : str
        Names of the angle bases.
    incident_rings, exitant_rings : list of (lower, upper, n)
        Polar angles [degree] and number of patches of each ring, from the normal outwards.
    nbytes : int
        Memory of the values [byte].
    """

    def __init__(self, core: _core.Matrix) -> None:
        self._core = core
        self.values = core.values
        self.incident_basis = core.incident_basis
        self.exitant_basis = core.exitant_basis
        self.incident_rings = core.incident_rings
        self.exitant_rings = core.exitant_rings
        self.nbytes = core.nbytes

    @classmethod
    def from_values(
        cls, values: ArrayLike, basis: str | list[tuple[float, float, int]] = "full", *, subdivide: int = 1
    ) -> Matrix:
        """Make a matrix of an array.

        Parameters
        ----------
        values
            [1/sr], (incident patches, exitant patches).
        basis, subdivide
            As in :meth:`Bsdf.to_klems`.

        Raises
        ------
        ValueError
            If the shape is not that of the basis, or a value is negative or not finite.
        """
        return cls(_core.matrix(np.asarray(values, np.float32), basis, subdivide))

    def projected_solid_angles(self) -> tuple[Array, Array]:
        """Projected solid angles [sr] of the incident and the exitant patches."""
        incident, exitant = _core.patch_areas(self._core)
        return incident, exitant

    def weighted(self) -> Array:
        """What dctimestep multiplies by: value times projected solid angle of the incident patch.

        Returns
        -------
        ndarray
            (exitant patches, incident patches): radiance out for radiance in. ``write_radiance_matrix`` writes it.
        """
        return np.asarray(self.values.T * self.projected_solid_angles()[0], np.float64)

    def __repr__(self) -> str:
        return repr(self._core)


def _wrapped(core: _core.Tree | _core.Matrix) -> Tree | Matrix:
    return Tree(core) if isinstance(core, _core.Tree) else Matrix(core)


class Bsdf:
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

    def __init__(self, core: _core.Bsdf) -> None:
        self._core = core
        header = core.header
        self.name: str = header["name"]
        self.manufacturer: str = header["manufacturer"]
        self.width: float | None = header["width"]
        self.height: float | None = header["height"]
        self.thickness: float | None = header["thickness"]
        self.unit: str = header["unit"]
        self.geometry: str | None = header["geometry"]
        self.provenance: list[str] = header["provenance"]
        self.properties: dict[str, str] = dict(header["properties"])
        self.repairs: list[str] = core.repairs
        self.bands: list[str] = core.bands

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

    def with_header(
        self,
        *,
        name: str | None = None,
        manufacturer: str | None = None,
        unit: str | None = None,
        provenance: list[str] | None = None,
        size: tuple[float | None, float | None, float | None] | None = None,
        geometry: tuple[str, str] | None = None,
        properties: Mapping[str, str] | None = None,
    ) -> Bsdf:
        """Return a copy with some of the header replaced.

        Parameters
        ----------
        name, manufacturer
            Of the product.
        unit
            Of lengths in the file: meter, foot, inch, centimeter or millimeter.
        provenance
            Comments at the head of the file.
        size
            Width, height and thickness [m].
        geometry
            MGF text, none if empty, and its unit of length.
        properties
            What else the file says of the material, by element, such as ``ThermalConductivity``.

        Raises
        ------
        ValueError
            If there is no such unit, or a file can hold no such property.
        """
        others = None if properties is None else list(properties.items())
        return Bsdf(self._core.with_header(name, manufacturer, unit, provenance, size, geometry, others))

    @property
    def components(self) -> dict[str, Tree | Matrix]:
        """Luminance of each component of the band ``Visible`` (or the only band), by name."""
        return self.components_of(self.bands[0] if "Visible" not in self.bands and self.bands else "Visible")

    def components_of(self, band: str) -> dict[str, Tree | Matrix]:
        """Luminance of each component of a band, by name."""
        return {key: _wrapped(functions[0]) for key, functions in self._core.components(band).items()}

    def chroma_of(self, band: str = "Visible") -> dict[str, tuple[Tree | Matrix, Tree | Matrix]]:
        """Colour of the components that have it: u′ and v′ trees, or X and Z matrices."""
        components = self._core.components(band)
        return {key: (_wrapped(f[1]), _wrapped(f[2])) for key, f in components.items() if len(f) == 3}

    def eval(self, incident: ArrayLike, exitant: ArrayLike, *, color: bool = False, band: str = "Visible") -> Array:
        """BSDF for pairs of directions.

        Parameters
        ----------
        incident, exitant
            Unit vectors away from the surface, (..., 3).
        color
            Whether to return CIE X, Y, Z instead of Y.
        band
            Spectral band.

        Returns
        -------
        ndarray
            [1/sr] without cosine, (...) or, with ``color``, (..., 3). Mitsuba and OpenPBR include |cos θ_exitant|:
            multiply by it there.

        Raises
        ------
        ValueError
            If shapes do not fit, a vector has no direction, or there is no such band.
        """
        i, o, shape = as_pairs(incident, exitant)
        if color:
            return self._core.eval_xyz(band, i, o).reshape(*shape, 3)
        return self._core.eval(band, i, o).reshape(shape)

    def smooth(self) -> Bsdf:
        """Return the BSDF with ramps instead of steps in the leaves of its trees.

        Inside a leaf the values then go up and down as those around it suggest; the mean over every leaf stays what it
        is, so that no light is gained or lost, and nothing is negative. ``eval``, ``sample``, ``pdf`` and
        ``hemispherical`` fit together as before. A function that the tree resolves is met several times better; a peak
        narrower than a leaf stays a block. Matrices and colour (u′, v′) stay constant over their cells. What is saved,
        converted or turned are the leaves, without ramps.

        Raises
        ------
        ValueError
            If there is no tree.

        Examples
        --------
        >>> x = (np.arange(8) + 0.5) / 8
        >>> b = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.broadcast_to(x, (8, 8, 8, 8)))})
        >>> from bsdftree import direction_from_polar
        >>> o = direction_from_polar([20, 25, 30], 90)
        >>> b.eval([0, 0, 1], o).round(3), b.smooth().eval([0, 0, 1], o).round(3)
        (array([0.688, 0.688, 0.812]), array([0.671, 0.711, 0.75 ]))
        """
        return Bsdf(self._core.smooth())

    @property
    def is_smooth(self) -> bool:
        """Whether there are ramps in the leaves of its trees: :meth:`smooth`."""
        return self._core.is_smooth

    def sample(
        self, incident: ArrayLike, u: ArrayLike, *, part: Part = "all", color: bool = False, band: str = "Visible"
    ) -> Sample:
        """Directions chosen in proportion to BSDF x |cos θ_exitant|.

        Parameters
        ----------
        incident
            Unit vectors, (..., 3).
        u
            Random numbers in [0, 1), one for each sample, (...), or two, (..., 2); for a single ``incident`` (n,) or
            (n, 2). One number runs along a Hilbert curve: stratified numbers give stratified directions.
        part
            ``"all"``, ``"reflection"`` or ``"transmission"``.
        color
            Whether the weights are CIE X, Y, Z instead of Y. Directions are chosen by Y all the same.
        band
            Spectral band.

        Returns
        -------
        Sample
            Directions, weights and densities.

        Examples
        --------
        >>> b = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.5 / np.pi))})
        >>> s = b.sample([0, 0, 1], np.linspace(0, 1, 8, endpoint=False))
        >>> s.exitant.shape, round(float(s.weight[0]), 6)
        ((8, 3), 0.5)
        """
        i, shape = as_rows("incident", incident)
        numbers = np.asarray(u, np.float64)
        if numbers.size and not ((numbers >= 0.0) & (numbers < 1.0)).all():
            raise ValueError("u holds numbers outside [0, 1)")
        two = numbers.ndim == max(len(shape) + 1, 2) and numbers.shape[-1] == 2
        lead = numbers.shape[:-1] if two else numbers.shape
        try:
            full = np.broadcast_shapes(shape, lead)
        except ValueError:
            raise ValueError(f"incident has shape {(*shape, 3)} and u {numbers.shape}; they do not broadcast") from None
        i = np.ascontiguousarray(np.broadcast_to(i.reshape(*shape, 3), (*full, 3)).reshape(-1, 3))
        columns = [numbers[..., k] for k in range(2)] if two else [numbers]
        flat = [np.ascontiguousarray(np.broadcast_to(c, full).reshape(-1)) for c in columns]
        exitant, weight, pdf = self._core.sample(band, i, flat[0], flat[1] if two else None, part)
        if color:
            share = np.divide(np.abs(exitant[:, 2]), pdf, out=np.zeros_like(pdf), where=pdf > 0)
            weight = self._core.eval_xyz(band, i, exitant) * share[:, None]
            return Sample(exitant.reshape(*full, 3), weight.reshape(*full, 3), pdf.reshape(full))
        return Sample(exitant.reshape(*full, 3), weight.reshape(full), pdf.reshape(full))

    def pdf(self, incident: ArrayLike, exitant: ArrayLike, *, part: Part = "all", band: str = "Visible") -> Array:
        """Density with which :meth:`sample` chooses ``exitant`` [1/sr of solid angle], (...)."""
        i, o, shape = as_pairs(incident, exitant)
        return self._core.pdf(band, i, o, part).reshape(shape)

    def hemispherical(self, incident: ArrayLike, part: Part = "all", *, band: str = "Visible") -> Array:
        """Fraction of the light from each direction that is scattered: directional-hemispherical totals.

        Parameters
        ----------
        incident
            Unit vectors, (..., 3).
        part
            ``"all"``, ``"reflection"`` or ``"transmission"``.
        band
            Spectral band.

        Returns
        -------
        ndarray
            In [0, 1] for a lawful BSDF, (...).
        """
        i, shape = as_rows("incident", incident)
        return self._core.hemispherical(band, i, part).reshape(shape)

    def projected_solid_angle(
        self, incident: ArrayLike, exitant: ArrayLike | None = None, *, part: Part = "all", band: str = "Visible"
    ) -> Array:
        """Resolution of the data.

        Parameters
        ----------
        incident
            Unit vectors, (..., 3).
        exitant
            Unit vectors, (..., 3). With them: the projected solid angle [sr] of the cell that holds each. Without: the
            smallest and largest among the cells that light from ``incident`` may leave through.
        part
            Which exitant side counts without ``exitant``.
        band
            Spectral band.

        Returns
        -------
        ndarray
            (...) with ``exitant``, else (..., 2). NaN where there is no component.
        """
        if exitant is not None:
            i, o, shape = as_pairs(incident, exitant)
            return self._core.projected_solid_angle(band, i, o).reshape(shape)
        i, shape = as_rows("incident", incident)
        return self._core.projected_solid_angle_range(band, i, part).reshape(*shape, 2)

    def lambertian(self, band: str = "Visible") -> dict[str, float]:
        """Lambertian part of each component: the reflectance or transmittance of its smallest value, if over 1 %."""
        return self._core.lambertian(band)

    def peaks(self, *, contrast: float = 10.0, min_strength: float = 0.002, band: str = "Visible") -> list[PeakFamily]:
        """Specular peaks: light that leaves in one direction for each direction it comes from.

        A cell is constant, so a peak in it is smeared: its flux is right, but the sun seen through it is as large as
        the cell, and as much too dim. Broad lobes and noise are not peaks, and in data coarser
        than 2^3 cells per axis none can be told.

        Parameters
        ----------
        contrast
            How many times brighter than what lies around it a peak is, at least; over 1.
        min_strength
            Least fraction of the light in it, in (0, 1); five times that, on average, where no map describes the peaks.
        band
            Spectral band.

        Returns
        -------
        list of PeakFamily
            By component, the one with the most light first. An absent transmission has the peaks of the other one,
            reversed.

        Raises
        ------
        ValueError
            If an argument is out of its range, or there is no such band.

        Examples
        --------
        >>> mirror = np.zeros((8, 8, 8, 8))
        >>> for a, b in np.ndindex(8, 8):
        ...     mirror[a, b, a, b] = 0.8 / (np.pi / 64)
        >>> family = Bsdf.from_trees({"reflection_back": Tree.from_grid(mirror)}).peaks()[0]
        >>> family.kind, round(family.mean_strength, 4)
        ('mirror', 0.8)
        """
        if not 1.0 < contrast < float("inf"):
            raise ValueError(f"contrast is {contrast}; expected a number over 1")
        if not 0.0 < min_strength < 1.0:
            raise ValueError(f"min_strength is {min_strength}; expected a fraction of the light in (0, 1)")
        return peak_families(_core.peaks(self._core, band, contrast, min_strength))

    def check(self, *, energy: float = 0.01, reciprocity: float = 0.25, noise: float = 0.25) -> Check:
        """Check energy, reciprocity, sides, orientation, units, noise and colour.

        Parameters
        ----------
        energy
            Tolerated excess of scattered over incident light.
        reciprocity
            Tolerated flux-weighted mean of |a - b| / (a + b) between pairs of directions and the same pairs swapped.
        noise
            Tolerated relative standard deviation of a value.

        Returns
        -------
        Check
            What was measured and found, by band.

        Examples
        --------
        >>> bright = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.4))})
        >>> [(finding.kind, finding.severity, round(finding.amount, 3)) for _, finding in bright.check().all()]
        [('energy', 'violation', 0.257)]
        """
        return check_of(*_core.check(self._core, energy, reciprocity, noise))

    def repaired(
        self,
        kinds: Sequence[str] = KINDS,
        *,
        energy: float = 0.01,
        reciprocity: float = 0.25,
        noise: float = 0.25,
    ) -> tuple[Bsdf, list[Mended]]:
        """Return a copy with findings mended, where they can be, and what was done.

        Parameters
        ----------
        kinds
            Which kinds of findings to mend; all by default.
        energy, reciprocity, noise
            What is tolerated, as in :meth:`check`.

        Returns
        -------
        Bsdf, list of Mended
            The copy, whose provenance says what was done, and that, with a number before and after. Without anything to
            mend, the copy is the same.

        Raises
        ------
        ValueError
            If there is no such kind.

        Examples
        --------
        >>> bright = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.4))})
        >>> mended, done = bright.repaired(["energy"])
        >>> [(m.what, m.measure, round(m.before, 3), round(m.after, 3)) for m in done]
        [('pairs of directions scaled down', 'largest total', 1.257, 1.0)]
        """
        core, done = _core.repaired(self._core, list(kinds), energy, reciprocity, noise)
        return Bsdf(core), [Mended(**mended) for mended in done]

    def to_klems(self, basis: str | list[tuple[float, float, int]] = "full", *, subdivide: int = 1) -> Bsdf:
        """Return the BSDF as matrices over an angle basis.

        Each value is the mean over incident and exitant patch by projected solid angle, from the areas that cells and
        patches share, cut out exactly. So totals are kept: the total of a patch is the mean of the totals over it.

        Parameters
        ----------
        basis
            ``"full"`` (145 patches), ``"half"`` (77; ``"half73"`` as it was before 2022), ``"quarter"`` (41), or rings
            as (lower, upper, n): polar angles [degree] and number of patches.
        subdivide
            Split each patch into this many by this many.

        Raises
        ------
        ValueError
            If there is no such basis, or it would have over 65536 patches.

        Examples
        --------
        >>> white = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.8 / np.pi))})
        >>> white.to_klems("quarter").components
        {'reflection_back': <Matrix LBNL/Klems Quarter (41) x LBNL/Klems Quarter (41)>}
        """
        return Bsdf(_core.to_klems(self._core, basis, subdivide))

    def to_tree(self, rank: int = 4, log2_res: int = 5, *, tolerance: float = 0.0) -> Bsdf:
        """Return the BSDF as tensor trees.

        Each value is the mean over its cell by projected solid angle, so totals are kept. Patches have borders where
        cells have none: :meth:`distance` says what that costs. Each level of resolution is up to sixteen times as many
        values, along all borders; a tolerance keeps them few.

        Parameters
        ----------
        rank
            3 averages over all turns about the normal; 4 keeps everything. Trees keep their rank, but may be coarsened.
        log2_res
            At most 2^log2_res cells per axis, 1 to 10.
        tolerance
            Relative L1 error that joining cells may add, in [0, 1). 0 joins equal ones only.

        Raises
        ------
        ValueError
            If an argument is out of its range, or a tree is of the other rank.
        """
        return Bsdf(_core.to_tree(self._core, rank, log2_res, tolerance))

    def rotated(self, angle_deg: float) -> Bsdf:
        """Return the BSDF of the device turned about its normal.

        Quarter turns, and of a matrix turns by whole patches of all rings, are exact. Others are resampled by the area
        that turned cells share with others, cut out exactly: light is kept, peaks get wider by up to a cell, and
        :meth:`distance` from the turn there and back says how much. Trees are turned at 2^7 cells per axis at most.
        Isotropic trees (rank 3) do not change. Geometry in the file is left out.

        Parameters
        ----------
        angle_deg
            Counter-clockwise as seen from the room [degree].
        """
        return Bsdf(_core.turned(self._core, angle_deg))

    def mirrored(self, axis: Literal["x", "y"] = "x") -> Bsdf:
        """Return the BSDF of the device mirrored: ``"x"`` swaps left and right, ``"y"`` up and down. Exact."""
        return Bsdf(_core.mirrored(self._core, axis))

    def flipped(self) -> Bsdf:
        """Return the BSDF of the device turned round about the vertical, its front to the back. Exact.

        What the properties say of the front is then said of the back: ``EmissivityFront``, ``EmissivityBack``.
        """
        turned = Bsdf(_core.flipped(self._core))
        other = {"EmissivityFront": "EmissivityBack", "EmissivityBack": "EmissivityFront"}
        swapped = {other.get(key, key): value for key, value in self.properties.items()}
        if swapped == self.properties:
            return turned
        # Where both are, in the order they had: the schema prescribes one.
        kept = {key: swapped[key] for key in self.properties if key in swapped}
        return turned.with_header(properties=swapped if len(kept) < len(swapped) else kept)

    def select(
        self,
        components: Sequence[str] | None = None,
        *,
        bands: Sequence[str] | None = None,
        rename: tuple[str, str] | None = None,
    ) -> Bsdf:
        """Return some of the BSDF.

        Parameters
        ----------
        components
            Which to take; all by default.
        bands
            Which to take; all by default.
        rename
            A band, and what it is to be called: a file of solar data may call it ``Visible``.

        Raises
        ------
        ValueError
            If there is no such component or band.
        """
        unknown = sorted(set(components or ()) - set(COMPONENTS))
        if unknown:
            raise ValueError(f"no component {unknown[0]!r}; expected one of {', '.join(COMPONENTS)}")
        chosen = None if components is None else list(components)
        return Bsdf(_core.chosen(self._core, chosen, None if bands is None else list(bands), rename))

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
