# The extension module: arrays in, arrays out. Rows of (n, 3) arrays are unit vectors, C-contiguous.
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]

__version__: str
MEASUREMENT_FORMATS: list[str]
XYZ_FROM_RGB: list[list[float]]

class Tree:
    rank: int
    depth: int
    n_leaves: int
    nbytes: int
    def _to_grid(self, log2_res: int) -> NDArray[np.float32]: ...
    def leaves(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32], NDArray[np.float32]]: ...

class Matrix:
    incident_basis: str
    exitant_basis: str
    incident_rings: list[tuple[float, float, int]]
    exitant_rings: list[tuple[float, float, int]]
    values: NDArray[np.float32]
    nbytes: int

class Bsdf:
    repairs: list[str]
    bands: list[str]
    header: dict[str, Any]
    @staticmethod
    def read(path: str, strict: bool) -> Bsdf: ...
    @staticmethod
    def of_components(components: dict[str, list[Tree | Matrix]]) -> Bsdf: ...
    def write(self, path: str, level: int | None) -> None: ...
    def verify(self) -> None: ...
    def smooth(self) -> Bsdf: ...
    is_smooth: bool
    def to_xml(self) -> str: ...
    def with_header(
        self,
        name: str | None = None,
        manufacturer: str | None = None,
        unit: str | None = None,
        provenance: list[str] | None = None,
        size: tuple[float | None, float | None, float | None] | None = None,
        geometry: tuple[str, str] | None = None,
        properties: list[tuple[str, str]] | None = None,
    ) -> Bsdf: ...
    def components(self, band: str) -> dict[str, list[Tree | Matrix]]: ...
    def lambertian(self, band: str) -> dict[str, float]: ...
    def eval(self, band: str, incident: _Array, exitant: _Array) -> _Array: ...
    def eval_xyz(self, band: str, incident: _Array, exitant: _Array) -> _Array: ...
    def pdf(self, band: str, incident: _Array, exitant: _Array, part: str) -> _Array: ...
    def sample(
        self, band: str, incident: _Array, u: _Array, v: _Array | None, part: str
    ) -> tuple[_Array, _Array, _Array]: ...
    def hemispherical(self, band: str, incident: _Array, part: str) -> _Array: ...
    def projected_solid_angle(self, band: str, incident: _Array, exitant: _Array) -> _Array: ...
    def projected_solid_angle_range(self, band: str, incident: _Array, part: str) -> _Array: ...

class Layout:
    n_incident: int
    n_exitant: int
    rings: list[tuple[float, float, int]]
    def __init__(
        self, *, rank: int, log2_res: int, klems: str | list[tuple[float, float, int]] | None, subdivide: int
    ) -> None: ...
    def exitant_areas(self) -> _Array: ...
    def starts(self, from_back: bool, cell: int, n: int, seed: int) -> _Array: ...
    def function(self, values: NDArray[np.float32]) -> Tree | Matrix: ...

_Scan = tuple[_Array, _Array, _Array, _Array | None, str]

class Measurement:
    n_channels: int
    name: str | None
    manufacturer: str | None
    symmetry: str | None
    wavelength_nm: float | None
    notes: list[str]
    parts: list[str]
    scans: list[_Scan]
    @staticmethod
    def read(
        paths: list[str], *, format: str | None, columns: str | None, side: str, grazing: float | None
    ) -> Measurement: ...
    @staticmethod
    def of_arrays(
        scans: list[_Scan],
        *,
        n_channels: int,
        name: str | None,
        manufacturer: str | None,
        symmetry: str | None,
        wavelength_nm: float | None,
        notes: list[str],
    ) -> Measurement: ...
    def summary(self) -> list[dict[str, Any]]: ...
    def to_pab_opto(self) -> list[tuple[str, str]]: ...

class Device:
    n_surfaces: int
    warnings: list[str]
    bounds: list[list[float]] | None
    tile: list[list[float]] | None
    @staticmethod
    def _read(kind: str, paths: list[str], options: dict[str, object]) -> Device: ...
    @staticmethod
    def _parse(kind: str, text: str, directory: str, options: dict[str, object]) -> Device: ...
    @staticmethod
    def _from_spec(spec: str) -> Device: ...
    def _with_materials(self, paths: list[str], options: dict[str, object]) -> Device: ...
    def _turned_up(self, up: str) -> Device: ...
    def to_rad(self) -> str: ...
    def to_mgf(self, unit: str) -> tuple[str, list[str]]: ...

class Generation:
    def paths(self) -> tuple[int, int]: ...
    def resumed(self) -> tuple[int, int, float, int] | None: ...
    def cancel(self) -> None: ...
    def wait(self, seconds: float) -> bool: ...
    def result(self) -> tuple[Bsdf, Bsdf, dict[str, Any]]: ...

def device_families() -> list[dict[str, Any]]: ...
def generate(
    device: Device,
    *,
    rank: int,
    log2_res: int,
    klems: str | list[tuple[float, float, int]] | None,
    subdivide: int,
    samples: int,
    tolerance: float | None,
    direction_tolerance: float,
    detail: float | None,
    time_budget: float | None,
    stratified: bool,
    sides: str,
    color: bool,
    reciprocity: bool | None,
    reuse: bool,
    pruned: bool,
    aperture: tuple[tuple[float, ...], tuple[float, ...]] | None,
    tile: bool,
    unit: str,
    seed: int,
    threads: int | None,
    checkpoint: str | None,
    geometry: bool = False,
    bands: list[str] | None = None,
    own: list[tuple[str, Device]] = ...,
) -> Generation: ...
def check(
    bsdf: Bsdf, energy: float, reciprocity: float, noise: float
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]: ...
def repaired(
    bsdf: Bsdf, kinds: list[str], energy: float, reciprocity: float, noise: float
) -> tuple[Bsdf, list[dict[str, Any]]]: ...
def faults(path: str) -> list[str]: ...
def peaks(bsdf: Bsdf, band: str, contrast: float, min_strength: float) -> list[dict[str, Any]]: ...
def to_klems(bsdf: Bsdf, klems: str | list[tuple[float, float, int]], subdivide: int) -> Bsdf: ...
def to_tree(bsdf: Bsdf, rank: int, log2_res: int, tolerance: float) -> Bsdf: ...
def from_callable(
    function: Callable[[_Array, _Array], _Array],
    rank: int,
    log2_res: int,
    tolerance: float,
    components: list[str],
    color: bool,
) -> Bsdf: ...
def from_cal(
    names: list[str],
    files: list[str],
    definitions: list[str],
    rank: int,
    log2_res: int,
    tolerance: float,
    components: list[str],
) -> Bsdf: ...
def relative_l1(reference: Tree | Matrix, other: Tree | Matrix) -> float: ...
def turned(bsdf: Bsdf, azimuth_deg: float) -> Bsdf: ...
def mirrored(bsdf: Bsdf, axis: str) -> Bsdf: ...
def flipped(bsdf: Bsdf) -> Bsdf: ...
def chosen(
    bsdf: Bsdf, components: list[str] | None, bands: list[str] | None, renamed: tuple[str, str] | None
) -> Bsdf: ...
def merge(parts: list[Bsdf]) -> tuple[Bsdf, list[str]]: ...
def stack(
    layers: list[Bsdf],
    klems: str | list[tuple[float, float, int]] | None,
    subdivide: int,
    log2_res: int | None,
    tolerance: float,
) -> Bsdf: ...
def layer_absorptances(
    layers: list[Bsdf],
    band: str,
    klems: str | list[tuple[float, float, int]] | None,
    subdivide: int,
    log2_res: int | None,
) -> _Array: ...
def matrix(values: NDArray[np.float32], klems: str | list[tuple[float, float, int]], subdivide: int) -> Matrix: ...
def patch_areas(matrix: Matrix) -> list[_Array]: ...
def read_radiance_matrix(bytes: bytes) -> _Array: ...
def write_radiance_matrix(path: str, values: _Array, format: str) -> None: ...

_Loss = tuple[float, float, float, float, tuple[float, float]]

class Goal:
    def __init__(
        self,
        *,
        l1: float | None = None,
        rms: float | None = None,
        total: float | None = None,
        n_leaves: int | None = None,
        norm: str = "l1",
        balance: float | None = None,
    ) -> None: ...

def tree_of_grid(
    values: NDArray[np.float32], rank: int, strict: bool, goal: Goal
) -> tuple[Tree, _Loss, str | None]: ...
def tree_of_noisy_grid(
    values: NDArray[np.float32], noise: NDArray[np.float32], is_counts: bool, rank: int, strict: bool, goal: Goal
) -> tuple[Tree, _Loss, str | None]: ...
def reduced(tree: Tree, goal: Goal) -> Tree: ...
def reduced_bsdf(bsdf: Bsdf, goal: Goal) -> Bsdf: ...
def reduced_bsdf_to(bsdf: Bsdf, most: int, of: str, goal: Goal) -> Bsdf: ...
def all_trees(bsdf: Bsdf) -> list[Tree]: ...
def with_trees(bsdf: Bsdf, trees: list[Tree]) -> Bsdf: ...
def loss(whole: Tree, reduced: Tree) -> _Loss: ...

_Score = tuple[str, str, bool, bool, float, float]

class Fit:
    def eval(self, incident: _Array, exitant: _Array) -> _Array: ...
    def error(self, incident: _Array, exitant: _Array) -> _Array: ...
    def bsdf(
        self,
        *,
        rank: int | None,
        log2_res: int | None,
        tolerance: float | None,
        progress: Callable[[int, int], None] | None,
    ) -> Bsdf: ...
    def errors_of(self, bsdf: Bsdf) -> Bsdf: ...
    def symmetry(self) -> tuple[str, str, list[tuple[str, float]]]: ...
    def notes(self) -> list[str]: ...
    def scores(self) -> list[tuple[str, list[_Score]]]: ...
    def reciprocity(self) -> list[tuple[str, tuple[bool, int, float, float] | None]]: ...
    def chosen(self) -> tuple[int, int, float]: ...

def fit(
    measurement: Measurement,
    *,
    symmetry: str | None,
    frame: str | None,
    reciprocal: bool | None,
    progress: Callable[[int, int], None] | None,
) -> Fit: ...
