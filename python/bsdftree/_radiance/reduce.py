"""Radiance's reducer of tensor trees, ``rttree_reduce``: a percentage of the tree is culled where it differs least.

In: dense values. Out: trees. Its text is read as the data of a file, by the reader for files.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bsdftree import _core
from bsdftree._radiance.programs import run

_FILE = """<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov">
<WindowElementType>System</WindowElementType><FileType>BSDF</FileType><Optical><Layer>
<DataDefinition><IncidentDataStructure>TensorTree{rank}</IncidentDataStructure></DataDefinition>
<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">Visible</Wavelength>
<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>
<WavelengthDataBlock><WavelengthDataDirection>Reflection Back</WavelengthDataDirection>
<AngleBasis>LBNL/Shirley-Chiu</AngleBasis><ScatteringDataType>BRDF</ScatteringDataType>
<ScatteringData>
{data}
</ScatteringData></WavelengthDataBlock></WavelengthData>
</Layer></Optical></WindowElement>
"""


def reducer_words(rank: int, log2_res: int, cull_percent: float, average: bool) -> list[object]:
    """Return the arguments of ``rttree_reduce`` for values as 32-bit numbers; ``average`` is reciprocity averaging."""
    return [*(["-a"] if average else []), "-h", "-ff", "-t", cull_percent, "-r", rank, "-g", log2_res]


def reduced(values: NDArray[np.float32], rank: int, log2_res: int, cull_percent: float, *, average: bool) -> _core.Tree:
    """Reduce values on a grid to a tree.

    Parameters
    ----------
    values
        2^(rank · log2_res) numbers, first axis slowest; of rank 3, the lower half of the first axis is enough.
    rank, log2_res
        Of the tree.
    cull_percent
        In [0, 100).
    average
        Whether to average pairs of directions with the same pairs swapped.
    """
    with tempfile.TemporaryDirectory(prefix="bsdftree-") as folder:
        path = Path(folder) / "tree.xml"
        write_reduced(path, values, rank, log2_res, cull_percent, average=average)
        (tree,) = _core.Bsdf.read(str(path), True).components("Visible")["reflection_back"]
    assert isinstance(tree, _core.Tree)
    return tree


def write_reduced(
    path: Path, values: NDArray[np.float32], rank: int, log2_res: int, cull_percent: float, *, average: bool
) -> None:
    """Write what :func:`reduced` reads: a file of one reflection, its numbers as ``rttree_reduce`` prints them."""
    arguments = reducer_words(rank, log2_res, cull_percent, average)
    text = run("rttree_reduce", *arguments, stdin=np.ascontiguousarray(values, np.float32).tobytes())
    path.write_text(_FILE.format(rank=rank, data=text.decode()))
