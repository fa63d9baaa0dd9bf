"""Klems matrices that we write are valid by LBNL's schema, which WINDOW reads by."""

from __future__ import annotations

import pytest

import bsdftree

CONVERTED = {
    "a tree": ("pyradiance/t3.xml", lambda b: b.to_klems("full")),
    "half, subdivided": ("pyradiance/blindsT3.xml", lambda b: b.to_klems("half", subdivide=2)),
    "quarter": ("frads/blinds30.xml", lambda b: b.to_klems("quarter")),
    "two bands, flipped": ("mermet/E_Screen_3pct_White.xml", lambda b: b.flipped()),
    "stacked": ("mermet/E_Screen_3pct_White.xml", lambda b: bsdftree.stack([b, b])),
}


@pytest.mark.parametrize("name", CONVERTED)
def test_matrices_are_valid(data, name):
    etree = pytest.importorskip("lxml.etree", reason="SKIPPED: no lxml; pip install lxml brings a validator")
    schema = etree.XMLSchema(etree.parse(data / "bsdfxmlparser/BSDF-v1.7.7.xsd"))
    path, convert = CONVERTED[name]
    text = convert(bsdftree.load(data / path, strict=False)).to_xml()
    document = etree.fromstring(text.encode())
    assert schema.validate(document), list(schema.error_log)
    # The schema knows no trees.
    tree = bsdftree.Bsdf.from_trees({"reflection_back": bsdftree.Tree.from_raw([0.1])})
    assert not schema.validate(etree.fromstring(tree.to_xml().encode()))
