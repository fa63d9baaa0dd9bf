"""Generator commands make what Radiance's programs print, without running them; nothing hostile gets through."""

import shlex
import time

import numpy as np
import pytest
import radiance
from radiance import needs_radiance

from bsdftree import Device

WHITE = "void plastic white 0 0 5 .7 .7 .7 0 0\n"

COMMANDS = [
    "genblinds white b .05 1 1 12 35",
    "genblinds white b .05 1 1 5 -20 -r .06",
    "genbox white b 1 2 3",
    "genbox white b 1 2 3 -b .25 -i",
    "genbox white b 1 2 3 -r .25",
    "genbox white b 1 2 3 -r .25 -n 6",
    "genprism white p 5 0 0 2 0 2 1 1 .5 0 1 -l 0 .25 -2",
    "genprism white p 5 0 0 2 0 2 1 1 .5 0 1 -l 0 0 -2 -r .1 -c",
    "gensurf white g s 't+s*s' 'sin(4*s)*t' 7 6",
    "gensurf white g s t 'f(s)*t' 4 5 -e 'f(x)=if(x-.5,x,x*x)' -e 'valid(s,t)=s-t+.6' -i",
    "genrev white r 'sin(2*t)' '1+t*t' 9",
    "genworm white w t 'bezier(0,1,3,1.5,t)' 'hermite(0,1,2,-1,t)' '.1+t/20' 11",
]


def statements(text: str) -> list[tuple[list[str], list[float]]]:
    """Surfaces of a scene: their words, and their real arguments."""
    words = [w for line in text.splitlines() if not line.startswith("#") for w in line.split()]
    found, at = [], 0
    while at < len(words):
        n = int(words[at + 5])
        head, reals = words[at : at + 3], words[at + 6 : at + 6 + n]
        assert words[at + 3 : at + 5] == ["0", "0"]
        if head[1] not in ("plastic",):
            found.append((head, [float(x) for x in reals]))
        at += 6 + n
    return found


@needs_radiance
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_make_what_radiance_makes(command):
    ours = statements(Device.parse(f"{WHITE}!{command}\n").to_rad())
    printed = radiance.run(*shlex.split(command)).decode()
    # Through our reader and writer too, which drop what has no area and turn radii about.
    theirs = statements(Device.parse(WHITE + printed).to_rad())
    assert [head for head, _ in ours] == [head for head, _ in theirs]
    for (head, a), (_, b) in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-10, err_msg=" ".join(head))


@needs_radiance
def test_marks_become_what_radiance_puts_there(tmp_path):
    (tmp_path / "knob.rad").write_text("white cone knob 0 0 8  .1 .2 .3  .5 .1 .2  .1 .05\n")
    rng = np.random.default_rng(3)
    marks = "".join(
        f"mark polygon m{k} 0 0 9 {' '.join(f'{x:.6f}' for x in rng.uniform(-5, 5, 9))}\n" for k in range(40)
    )
    (tmp_path / "marks.rad").write_text(WHITE + marks)
    command = "replmarks -s 1.5 -x knob.rad mark marks.rad"
    ours = statements(Device.parse(f"{WHITE}!{command}\n", directory=tmp_path).to_rad())
    printed = radiance.run(*shlex.split(command), cwd=tmp_path).decode()
    theirs = statements(Device.parse(printed, directory=tmp_path).to_rad())
    assert len(ours) == 40 and [head for head, _ in ours] == [head for head, _ in theirs]
    for (head, a), (_, b) in zip(ours, theirs, strict=True):
        # Radiance prints six decimals of angles in degrees and of lengths.
        np.testing.assert_allclose(a, b, atol=2e-5, err_msg=" ".join(head))


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ("!genclock clock\n", "--allow-command genclock"),
        ("!genbox white b 1 1 1; touch x\n", "';' in the command"),
        ("!genbox white b 1 1 `touch x`\n", "'`' in the command"),
        ("!gensurf white g s t 's*t' 1e5 1e5\n", "statements that a command makes"),
        ("!genworm white w t 0 0 1 1e9\n", "statements that a command makes"),
        ("!genworm white w 'f(t)' 0 0 1 9 -e 'f(x) = f(x+1)'\n", "recursion"),
        ("!genprism white p missing.txt\n", "missing.txt"),
        ("!genbox white b 1 1 1 | xform -a 1e9 -t 1 0 0\n", "more than"),
        ("!genrev white r t nothing 3\n", "'nothing' is not defined"),
    ],
)
def test_hostile_commands_are_refused_soon_with_their_line(tmp_path, monkeypatch, scene, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError) as caught:
        Device.parse(f"{WHITE}\n{scene}")
    assert "text:3" in str(caught.value) and message in str(caught.value)
    assert not (tmp_path / "x").exists()


def test_an_allowed_program_runs_without_a_shell(tmp_path):
    (tmp_path / "ball.rad").write_text("white sphere s 0 0 4 0 0 0 1\n")
    scene = f"{WHITE}!head -n 1 ball.rad | xform -t 2 0 0\n"
    device = Device.parse(scene, directory=tmp_path, allow_commands=["head"])
    assert device.bounds == [[1, -1, -1], [3, 1, 1]]
    with pytest.raises(ValueError, match="'head' is not supported"):
        Device.parse(scene, directory=tmp_path)
    with pytest.raises(ValueError, match=r"the command 'head \$HOME' failed"):
        Device.parse("!head '$HOME'\n", directory=tmp_path, allow_commands=["head"])


def test_files_that_include_each_other_are_named(tmp_path):
    (tmp_path / "a.rad").write_text("!xform b.rad\n")
    (tmp_path / "b.rad").write_text("\n!xform a.rad\n")
    began = time.monotonic()
    with pytest.raises(ValueError, match="in a circle"):
        Device.read(tmp_path / "a.rad")
    print(f"after {time.monotonic() - began:.3f} s")
