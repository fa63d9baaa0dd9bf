"""What a BSDF is asked: values, samples, densities, totals, resolution, peaks, and whether it can be."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bsdftree import _core
from bsdftree._check import Check, check_of
from bsdftree._component import Array
from bsdftree._directions import as_pairs, as_rows
from bsdftree._header import Described
from bsdftree._peaks import PeakFamily, peak_families

Part = Literal["all", "reflection", "transmission"]


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


class Queries(Described):
    """Questions that take arrays of unit vectors of shape (..., 3), broadcast against each other; thread-safe."""

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
        >>> from bsdftree import Bsdf, Tree
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
        >>> from bsdftree import Bsdf, Tree
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
        >>> from bsdftree import Bsdf, Tree
        >>> bright = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.4))})
        >>> [(finding.kind, finding.severity, round(finding.amount, 3)) for _, finding in bright.check().all()]
        [('energy', 'violation', 0.257)]
        """
        return check_of(*_core.check(self._core, energy, reciprocity, noise))
