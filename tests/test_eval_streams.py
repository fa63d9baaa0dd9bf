"""``bsdftree eval`` in a pipe: vectors and angles, text and binary, in blocks."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree.cli import _pairs, main

FILE = "pyradiance/ven45.xml"


@pytest.fixture
def pairs(rng):
    """Incident and exitant vectors, (n, 6), of any length."""
    return rng.normal(size=(500, 6))


def evaluate(data, given: bytes | str, *words: str):
    """Output of the verb, as bytes."""
    done = CliRunner().invoke(main, ["eval", str(data / FILE), *words], input=given)
    assert done.exit_code == 0, done.output
    return done.stdout_bytes


@pytest.mark.parametrize("block", [7, 1 << 16])
@pytest.mark.parametrize(("letters", "dtypes"), [("f", "ff"), ("d", "dd"), ("fd", "fd"), ("df", "df")])
def test_binary_pairs_have_the_values_of_python(data, pairs, monkeypatch, block, letters, dtypes):
    monkeypatch.setattr(_pairs, "BLOCK", block)
    given = pairs.astype(dtypes[0])
    found = np.frombuffer(evaluate(data, given.tobytes(), "--vectors", "-f", letters, "--color"), dtypes[1])
    unit = [v / np.linalg.norm(v, axis=1, keepdims=True) for v in np.split(given.astype(float), 2, axis=1)]
    expected = bsdftree.load(data / FILE).eval(*unit, color=True)
    np.testing.assert_allclose(found.reshape(-1, 3), expected, rtol=1e-6)


def test_text_and_angles_have_the_values_of_vectors(data, pairs, monkeypatch):
    monkeypatch.setattr(_pairs, "BLOCK", 64)
    text = "\n".join(" ".join(map(str, row)) for row in pairs)
    from_text = np.array(evaluate(data, text, "--vectors", "--pdf").split(), float).reshape(-1, 2)
    halves = [half / np.linalg.norm(half, axis=1, keepdims=True) for half in np.split(pairs, 2, axis=1)]
    angles = np.hstack([bsdftree.polar_from_direction(half) for half in halves])
    from_angles = np.frombuffer(evaluate(data, angles.tobytes(), "-fd", "--pdf"), float).reshape(-1, 2)
    np.testing.assert_allclose(from_text, from_angles, rtol=1e-6)
    assert (from_text[:, 0] > 0).mean() > 0.9


@pytest.mark.parametrize(
    ("words", "given", "said", "code"),
    [
        (["-ff"], b"\0" * 17, "ends 1 bytes after pair 1; expected four angles", 1),
        (["--vectors"], b"0 0 1 0 0 1\n0 0 1 0 0\n", "line 2: 5 numbers; expected six components", 1),
        (["--vectors"], b"0 0 0 0 0 1\n", "expected finite ones that are not 0", 1),
        (["-fx"], b"", "letters of a, f and d", 2),
        (["--json", "-faf"], b"1 2 3 4\n", "--json is text", 2),
        ([], b"", "no pairs", 2),
        (["1", "2", "3"], b"", "four to a pair", 2),
    ],
)
def test_faulty_streams_are_refused(data, words, given, said, code):
    done = CliRunner().invoke(main, ["eval", str(data / FILE), *words], input=given)
    assert done.exit_code == code and said in done.output, done.output


def test_negative_angles_are_no_options(data):
    first, second = (evaluate(data, b"", "30", phi, "30", "270") for phi in ("-90", "270"))
    assert first == second
