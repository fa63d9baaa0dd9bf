"""Generations that are killed, stopped or refused, at the prompt and in Python."""

import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import bsdftree

# Some seconds, with diffused light reused, and a last round that is cut short.
JOB = ["--device", "blinds", "--log2-res", "5", "--samples", "2000", "--threads", "2", "--checkpoint", "kept"]
SMALL = [*JOB[:2], "--log2-res", "4", "--samples", "500", "--checkpoint", "kept"]
N_KILLS = 20


def command(*args: str) -> list[str]:
    return [sys.executable, "-m", "bsdftree", "generate", *args, "-o", "out.xml"]


def run(where: Path, *args: str, **kwargs) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command(*args), cwd=where, capture_output=True, text=True, timeout=120, check=False, **kwargs)


def start(where: Path, *args: str) -> subprocess.Popen[str]:
    return subprocess.Popen(command(*args), cwd=where, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def begun(where: Path) -> None:
    """Wait until something was counted."""
    while not any(f.stat().st_size for f in (where / "kept").glob("*.blocks")):
        time.sleep(0.01)


def values(xml: bytes) -> bytes:
    """Everything but the command line."""
    return b"\n".join(line for line in xml.splitlines() if not line.startswith(b"<!-- Command:"))


def result(where: Path) -> bytes:
    return (where / "out.xml").read_bytes()


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory) -> tuple[bytes, float]:
    """The result, and the seconds it takes."""
    where = tmp_path_factory.mktemp("uninterrupted")
    begin = time.perf_counter()
    done = run(where, *JOB)
    assert done.returncode == 0 and "resuming" not in done.stderr, done.stderr
    seconds = time.perf_counter() - begin
    plain = run(where, *JOB[:-2])
    assert plain.returncode == 0
    kept = (where / "kept").iterdir()
    assert sorted(f.name for f in kept)[:2] == ["0-64.blocks", "1024-2000.blocks"]
    xml = result(where)
    done = run(where, *JOB)
    assert "nothing left to count: the checkpoint has 2000 samples" in done.stderr
    assert values(result(where)) == values(xml)
    return result(where), seconds


def test_killed_at_random_times_it_ends_with_the_same_bytes(uninterrupted, tmp_path, rng):
    """The same command, in another directory of the same name, each time killed a little later until it is done."""
    xml, seconds = uninterrupted
    n_kills = n_ends = n_resumed = 0
    while n_kills < N_KILLS or n_ends == 0:
        process = start(tmp_path, *JOB)
        try:
            _, stderr = process.communicate(timeout=None if n_kills >= N_KILLS else seconds * rng.uniform(0.1, 0.7))
        except subprocess.TimeoutExpired:
            process.kill()
            _, stderr = process.communicate()
            # Otherwise it ended just before.
            if process.returncode == -signal.SIGKILL:
                n_kills += 1
                n_resumed += "resuming at sample" in stderr or "nothing left to count" in stderr
                continue
        assert process.returncode == 0, stderr
        n_resumed += "resuming at sample" in stderr or "nothing left to count" in stderr
        assert result(tmp_path) == xml
        n_ends += 1
        shutil.rmtree(tmp_path / "kept")
        (tmp_path / "out.xml").unlink()
    assert n_resumed > 0


def test_ctrl_c_keeps_what_was_counted(uninterrupted, tmp_path):
    process = start(tmp_path, *JOB)
    begun(tmp_path)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 1 and "kept keeps what was counted, the same command goes on" in stderr
    done = run(tmp_path, *JOB)
    assert done.returncode == 0 and "of 2000, " in done.stderr and "bytes were not whole" not in done.stderr
    assert result(tmp_path) == uninterrupted[0]


def test_two_runs_do_not_share_a_checkpoint(tmp_path):
    process = start(tmp_path, *JOB)
    begun(tmp_path)
    second = run(tmp_path, *JOB)
    process.kill()
    process.communicate()
    assert second.returncode == 1 and "kept is in use by another run" in second.stderr
    # A lock ends with the process that held it.
    third = start(tmp_path, *JOB)
    size = sum(f.stat().st_size for f in (tmp_path / "kept").glob("*.blocks"))
    while third.poll() is None and sum(f.stat().st_size for f in (tmp_path / "kept").glob("*.blocks")) <= size:
        time.sleep(0.01)
    third.kill()
    assert "in use" not in third.communicate()[1]


def test_another_job_is_refused_with_what_differs(tmp_path):
    rad = tmp_path / "mirror.rad"
    rad.write_text("void mirror m 0 0 3 .9 .9 .9\nm polygon p 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n")
    job = [str(rad), "--log2-res", "3", "--samples", "100", "--checkpoint", "kept"]
    assert run(tmp_path, *job).returncode == 0
    for change, message in [
        (["--seed", "1"], "seed 1 here, but 0 there"),
        (["--log2-res", "4"], "layout tree of rank 4 with 2^4 cells per axis here, but tree of rank 4 with 2^3"),
        (["--klems", "full"], "layout Klems basis of 145 patches"),
        (["--sides", "front"], "sides front here, but both there"),
        (["--color"], "color yes here, but no there"),
        (["--sampling", "random"], "sampling random here, but sobol there"),
        (["--dim", "-1", "1", "-1", "0.5", "-1", "0"], "aperture "),
    ]:
        refused = run(tmp_path, *job, *change)
        assert refused.returncode == 1 and message in refused.stderr, refused.stderr
        assert "give the same device and options, or another directory" in refused.stderr
    rad.write_text(rad.read_text().replace(".9 .9 .9", ".8 .8 .8"))
    refused = run(tmp_path, *job)
    assert refused.returncode == 1 and "mirror m1" in refused.stderr and '"3 0.8 0.8 0.8" here' in refused.stderr
    assert run(tmp_path, *job[:-1], ".").stderr.count("is no checkpoint and has") == 1
    assert rad.exists()


def test_no_room_is_reported_and_nothing_is_lost(tmp_path):
    assert run(tmp_path, *SMALL[:-2], "--checkpoint", "other").returncode == 0
    expected = values(result(tmp_path))
    largest = max(f.stat().st_size for f in (tmp_path / "other").iterdir())

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest // 2, largest // 2))

    full = run(tmp_path, *SMALL, preexec_fn=limit)
    assert full.returncode == 1, full.stderr
    assert "cannot write" in full.stderr and "File too large" in full.stderr and "is kept" in full.stderr
    done = run(tmp_path, *SMALL)
    assert done.returncode == 0 and "resuming at sample" in done.stderr
    assert values(result(tmp_path)) == expected


def test_python_goes_on_with_more_samples(tmp_path):
    seen: list[bsdftree.Resumed] = []

    def generated(samples: int, checkpoint: Path | None) -> bytes:
        b = bsdftree.generate("sawtooth", log2_res=3, samples=samples, checkpoint=checkpoint, resumed=seen.append)
        return b.to_xml().encode()

    first = generated(300, tmp_path / "kept")
    assert first == generated(300, None) and seen == []
    assert generated(300, tmp_path / "kept") == first
    assert generated(600, tmp_path / "kept") == generated(600, None)
    # Rounds end at powers of two: what was counted after 256 was counted in a round that was cut short.
    assert seen == [bsdftree.Resumed(300, 300, 0.0, 0), bsdftree.Resumed(256, 512, 0.0, 0)]
    with pytest.raises(ValueError, match="seed 7 here, but 0 there"):
        bsdftree.generate("sawtooth", log2_res=3, samples=600, seed=7, checkpoint=tmp_path / "kept")
