"""Variable-resolution BSDFs: generate, read, evaluate, sample, check and draw them.

A BSDF f(incident, exitant) [1/sr] says how a surface or a whole window system scatters light. Directions are unit
vectors that point **away** from the surface, the incident one too: X is right seen from the front, Y is up, and +Z,
the front, is the room. Values have **no cosine**.

>>> import bsdftree
>>> device = bsdftree.Device.from_spec("mirror:reflectance=0.9")
>>> b = bsdftree.generate(device, rank=3, log2_res=4, samples=64)
>>> round(float(b.hemispherical([0, 0.6, 0.8], part="reflection")), 3)
0.9
"""

from bsdftree._bsdf import Bsdf, load
from bsdftree._check import BandCheck, Check, Energy, Finding, Gamut, Mended, Noise, Reciprocity, Symmetry
from bsdftree._combine import layer_absorptances, merge, stack
from bsdftree._component import Matrix, Tree
from bsdftree._core import __version__
from bsdftree._device import Device, Family, Parameter, device_families
from bsdftree._directions import direction_from_polar, polar_from_direction
from bsdftree._energyplus import energyplus
from bsdftree._energyplus_file import save_energyplus
from bsdftree._fit import Fit, FittedTrees, Recipe, SwappedPairs, fit
from bsdftree._fit_summary import DirectionTotal, FitSummary, PartSummary
from bsdftree._generate import generate
from bsdftree._lobes import save_lobes
from bsdftree._matrix_files import read_radiance_matrix, write_radiance_matrix
from bsdftree._measurement import Measurement, Scan
from bsdftree._package import package
from bsdftree._peaks import Peak, PeakFamily
from bsdftree._queries import Sample
from bsdftree._reduce import Loss, Reduction
from bsdftree._report import BandReport, GenerationReport, Resumed
from bsdftree._standard_errors import ErrorByFlux, errors_by_flux
from bsdftree._viewer import Viewer, save_view, view

__all__ = [
    "BandCheck",
    "BandReport",
    "Bsdf",
    "Check",
    "Device",
    "DirectionTotal",
    "Energy",
    "ErrorByFlux",
    "Family",
    "Finding",
    "Fit",
    "FitSummary",
    "FittedTrees",
    "Gamut",
    "GenerationReport",
    "Loss",
    "Matrix",
    "Measurement",
    "Mended",
    "Noise",
    "Parameter",
    "PartSummary",
    "Peak",
    "PeakFamily",
    "Recipe",
    "Reciprocity",
    "Reduction",
    "Resumed",
    "Sample",
    "Scan",
    "SwappedPairs",
    "Symmetry",
    "Tree",
    "Viewer",
    "__version__",
    "device_families",
    "direction_from_polar",
    "energyplus",
    "errors_by_flux",
    "fit",
    "generate",
    "layer_absorptances",
    "load",
    "merge",
    "package",
    "polar_from_direction",
    "read_radiance_matrix",
    "save_energyplus",
    "save_lobes",
    "save_view",
    "stack",
    "view",
    "write_radiance_matrix",
]
