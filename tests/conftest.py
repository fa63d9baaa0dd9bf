"""What all tests share: the folder of real files, and the visible mark of its absence."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("BSDFTREE_DATA", ROOT / ".." / "shared" / "data")).resolve()
NO_DATA = f"SKIPPED: no data folder at {DATA}; set BSDFTREE_DATA to the folder of real files"


@pytest.fixture(scope="session")
def data() -> Path:
    """Folder of real files that none of the authors wrote."""
    if not DATA.is_dir():
        pytest.skip(NO_DATA)
    return DATA


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers that are the same in every run."""
    return np.random.default_rng(20140304)
