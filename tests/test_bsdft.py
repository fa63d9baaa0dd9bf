"""Binary files from Python and at the prompt: the same to the last bit, whichever way."""

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree import Bsdf, Tree
from bsdftree.cli import main


@pytest.fixture
def run():
    def run(*args):
        return CliRunner().invoke(main, [str(a) for a in args])

    return run


def readable(data):
    return sorted(p for p in data.glob("*/*") if p.suffix.lower() == ".xml" and "Small" not in p.name)


@pytest.fixture
def blinds(data):
    return data / "pyradiance/blinds.xml"


@pytest.mark.parametrize("options", [(), ("--packed",), ("--packed", "--level", "1")])
def test_every_real_file_goes_to_binary_and_back_without_loss(run, data, tmp_path, options):
    for path in readable(data):
        twin, back, direct = (tmp_path / name for name in ("twin.bsdft", "back.xml", "direct.xml"))
        for source, target, more in ((path, twin, options), (twin, back, ()), (path, direct, ())):
            result = run("convert", *more, source, target)
            assert result.exit_code == 0, result.output
        assert back.read_bytes() == direct.read_bytes(), path
        assert twin.read_bytes().startswith(b"BSDFT\r\n")


def test_the_verbs_say_the_same_of_either_file(run, blinds, tmp_path):
    twin = tmp_path / "blinds.bsdft"
    bsdftree.load(blinds).save(twin)
    for verb in (("check",), ("info", "--json"), ("info", "--peaks"), ("eval", "--color", "--pdf")):
        angles = (30, 90, 150, 270) if verb[0] == "eval" else ()
        outputs = [run(*verb, path, *angles) for path in (blinds, twin)]
        assert [o.exit_code for o in outputs] == [0, 0], outputs[1].output
        sizes = [f"{path.stat().st_size}" for path in (blinds, twin)]
        spelled = [
            o.output.replace(str(path), "FILE").replace(f"{int(size):,}", "SIZE").replace(size, "SIZE")
            for o, path, size in zip(outputs, (blinds, twin), sizes, strict=True)
        ]
        assert spelled[0] == spelled[1]
    assert run("plot", twin, "-o", tmp_path / "blinds.png").exit_code == 0


def test_generate_writes_binary_by_the_ending(run, tmp_path):
    options = ("generate", "--device", "mirror", "--rank", 3, "--log2-res", 3, "--samples", 50)
    for name in ("m.xml", "m.bsdft"):
        assert run(*options, "-o", tmp_path / name).exit_code == 0
    xml, binary = (bsdftree.load(tmp_path / name) for name in ("m.xml", "m.bsdft"))
    assert xml.to_xml().partition("<WindowElement ")[2] == binary.to_xml().partition("<WindowElement ")[2]


def test_trees_of_both_ranks_and_matrices_may_be_in_one_file(blinds, data, tmp_path):
    b = Bsdf.from_trees(
        {
            "reflection_front": Tree.from_grid(np.arange(512).reshape(8, 8, 8)),
            "reflection_back": Tree.from_grid(np.arange(256).reshape(4, 4, 4, 4)),
        }
    )
    b.save(tmp_path / "both.bsdft")
    again = bsdftree.load(tmp_path / "both.bsdft")
    assert [tree.rank for tree in again.components.values()] == [4, 3]
    with pytest.raises(OSError, match="convert one of them"):
        again.save(tmp_path / "both.xml")


def test_damage_is_found_by_every_verb_and_by_verify(run, blinds, tmp_path):
    twin = tmp_path / "blinds.bsdft"
    bsdftree.load(blinds).save(twin)
    damaged = bytearray(twin.read_bytes())
    damaged[-1000] ^= 0x40
    twin = tmp_path / "damaged.bsdft"
    twin.write_bytes(damaged)
    b = bsdftree.load(twin)
    assert np.isfinite(b.eval([0, 0, 1], [0, 0.6, -0.8]))
    with pytest.raises(ValueError, match=r"byte \d+: found .*damaged, so copy or make it again"):
        b.verify()
    assert not b.check().ok
    for verb in (("info",), ("check",), ("convert",), ("plot",)):
        more = [tmp_path / "out.xml"] if verb == ("convert",) else []
        result = run(*verb, twin, *more)
        assert result.exit_code == 1 and f"{twin}: byte" in result.output, result.output
    with pytest.raises(ValueError, match="damaged"):
        (tmp_path / "short.bsdft").write_bytes(damaged[:5000])
        bsdftree.load(tmp_path / "short.bsdft")


def test_only_bsdft_files_are_packed_and_levels_are_levels(run, blinds, tmp_path):
    b = bsdftree.load(blinds)
    with pytest.raises(ValueError, match=r"only files that end in \.bsdft can be packed"):
        b.save(tmp_path / "x.xml", packed=True)
    with pytest.raises(ValueError, match="1 to 22"):
        b.save(tmp_path / "x.bsdft", packed=True, level=23)
    assert run("convert", "--packed", blinds, tmp_path / "x.xml").exit_code == 1
    assert run("convert", "--packed", "--level", 0, blinds, tmp_path / "x.bsdft").exit_code == 2
    assert not list(tmp_path.glob("*"))


def test_a_missing_file_is_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        bsdftree.load(tmp_path / "none.bsdft")
