"""The argument grammar of genBSDF, on command lines of people who use it.

Each is as its source runs it, with numbers where the source fills them in; what stands behind it is the word genBSDF.
"""

import shlex

import pytest

from bsdftree.cli._genbsdf_words import Request, UsageError, request

BOTH = {"forward": True, "backward": True}

COMMANDS = [
    # Radiance's manual page, versions 1.10 to 1.24.
    ("man page", "-r @rtc.opt blind_white.mat glazing.rad blind1.rad",
     {"rcontrib": ["@rtc.opt"], "files": ["blind_white.mat", "glazing.rad", "blind1.rad"]}),
    ("man page", "-r @rtc.opt -t4 7 -c 160000 blind_white.mat glazing.rad blind1.rad",
     {"rank": 4, "log2_res": 7, "samples": 160_000}),
    ("man page", "-s m=MF -s n=NM d.rad", {"fields": {"Manufacturer": "MF", "Name": "NM"}}),
    ("man page 1.14", "-W -f 'm=MF;n=NM' d.rad", {"window": True, "fields": {"Manufacturer": "MF", "Name": "NM"}}),
    ("man page", "-t4 5 -c 10240 d.rad", {"rank": 4, "log2_res": 5, "samples": 10_240}),
    ("man page", "-recover /tmp/genBSDF.vRnG3w", {"recover": "/tmp/genBSDF.vRnG3w"}),
    # In files: "Created by: genBSDF …".
    ("LBNL-ETA/Radiance test/", "-geom millimeter -dim -120 120 -120 120 -2 0 -n 4 sawtooth.rad",
     {"geometry": False, "unit": "millimeter", "dim": (-120, 120, -120, 120, -2, 0), "processes": 4}),
    ("LBNL-ETA/Radiance test/", "-t4 4 -t -1 sawtooth.rad", {"rank": 4, "log2_res": 4, "cull_percent": -1.0}),
    ("LBNL-ETA/pyradiance blinds.xml",
     "-n 16 -c 10000 -r '-ad 20000 -lw 0.00005 -ab 5' +forward +backward +geom meter Blinds.rad",
     BOTH | {"rcontrib": ["-ad", "20000", "-lw", "0.00005", "-ab", "5"], "samples": 10_000, "processes": 16}),
    ("LBNL-ETA/pyradiance blindsT3.xml",
     "-n 16 -c 10000 -r '-ad 20000 -lw 0.00005 -ab 5' +forward +backward +geom meter -t3 5 Blinds.rad",
     BOTH | {"rank": 3, "log2_res": 5, "geometry": True, "unit": "meter"}),
    ("LBNL-ETA/frads blinds30.xml",
     "-n 4 -f +b -c 500 +geom meter -dim -1.355 1.355 -0.855 0.855 -0.03165063509461097 0 tmp_blinds.rad",
     {"forward": False, "samples": 500, "dim": (-1.355, 1.355, -0.855, 0.855, -0.03165063509461097, 0)}),
    # LBNL-ETA/frads, gen_bsdf and its forerunners.
    ("frads", "-n 4 +f +b -c 500 -geom meter -dim -0.025 0.025 -0.012 0.012 -0.05 0 tmp_blinds.rad",
     BOTH | {"geometry": False, "dim": (-0.025, 0.025, -0.012, 0.012, -0.05, 0)}),
    ("frads", "-n 4 +f +b -geom meter -dim -0.025 0.025 -0.012 0.048 -0.05 0 tmp_blinds.rad",
     BOTH | {"geometry": False}),
    ("frads", "-n 4 -f +b -r '-ab 5 -ad 700 -lw 3e-6' -c 500 +geom meter -dim -1 1 -1 1 -0.05 0 tmp_blinds.rad",
     {"forward": False, "rcontrib": ["-ab", "5", "-ad", "700", "-lw", "3e-6"]}),
    ("frads", "-n 4 -f +b -geom meter -dim -0.025 0.025 -0.012 0.028 -0.04 0 /tmp/x/blinds.rad",
     {"forward": False, "geometry": False, "samples": 2000}),
    # NREL/OpenStudio, genBSDFLib.rb.
    ("OpenStudio", "-n 8 ./cl_0.4.rad", {"processes": 8, "files": ["./cl_0.4.rad"]}),
    ("OpenStudio", "-n 8 ./OSRadWin_040_100_bl.rad", {"processes": 8, "rank": 0}),
    # rgsouthall/vi-suite; the scene comes by standard input.
    ("vi-suite", "-geom meter -t4 4 -c 1024 +b -f -n 4",
     {"geometry": False, "rank": 4, "samples": 1024, "forward": False, "files": []}),
    ("vi-suite", "+geom meter -r ''     -c 200 +b -f -n 8", {"rcontrib": [], "samples": 200, "geometry": True}),
    ("vi-suite", "+geom meter -r '-ab 4'     -c 200 +f -b -n 8", {"forward": True, "backward": False}),
    ("vi-suite", "+geom millimeter -r '' -t3 5 -c 4096 +b +f -n 2", BOTH | {"unit": "millimeter", "rank": 3}),
    ("vi-suite", "+geom centimeter -r '-ab 10 -ad 4096' -t4 7 -c 65536 +b -f -n 8",
     {"unit": "centimeter", "rank": 4, "log2_res": 7, "samples": 65_536}),
    # LBNL-ETA/pyradiance, genbsdf() while the wheel had the script.
    ("pyradiance", "-n 1 -c 1 +a -f +b -mgf -C -s '' d.rad",
     {"samples": 1, "average": True, "color": False, "fields": {}}),
    ("pyradiance", "-n 4 -c 2000 -r '-ab 2' -t4 5 -a +geom meter +f +b -mgf +C -dim 0 1 0 1 -1 0 -W "
     "-s 'n=Shade;m=ACME;d=Film;c=0.15;ef=.8;eb=.7;eo=.03;t=.01;h=1;w=1' d.rad",
     BOTH | {"average": False, "color": True, "window": True, "fields": {
         "Name": "Shade", "Manufacturer": "ACME", "DeviceType": "Film", "ThermalConductivity": "0.15",
         "EmissivityFront": ".8", "EmissivityBack": ".7", "EffectiveOpennessFraction": ".03", "Thickness": ".01",
         "Height": "1", "Width": "1"}}),
    ("pyradiance", "-n 2 -c 100 -t3 4 +a +geom inch -f +b +mgf -C -s n=x d.mgf",
     {"mgf": True, "unit": "inch", "rank": 3, "fields": {"Name": "x"}}),
    # ladybug-tools/honeybee, to_rad_string().
    ("honeybee", "-c 102121 -n 10 -t3 7 +geom meter -dim 0 1 2 3 4 5 -r '-ab 45' room/glazing.rad",
     {"samples": 102_121, "log2_res": 7, "dim": (0, 1, 2, 3, 4, 5), "rcontrib": ["-ab", "45"]}),
    ("honeybee", "-n 10 +geom meter -r '-ab 1' room/room.mat room/glazing.rad",
     {"files": ["room/room.mat", "room/glazing.rad"]}),
    ("honeybee", "-n 10 +forward -backward +mgf -geom foot d.mgf",
     {"forward": True, "backward": False, "mgf": True, "geometry": False, "unit": "foot"}),
    # What the script does with its words, by its own rules.
    ("script", "d.rad", {}),
    ("script", "", {"files": []}),
    ("script", "+forw -backw d.rad", {"forward": True, "backward": False}),
    ("script", "+m -g Meter d.mgf", {"mgf": True, "geometry": False, "unit": "meter"}),
    ("script", "-t 95 -t4 6 d.rad", {"cull_percent": 95.0, "rank": 4}),
    ("script", "-t4 6 -t3 5 d.rad", {"rank": 3, "log2_res": 5}),
    ("script", "+C -C d.rad", {"color": False}),
    ("script", "-c 10 -c 20 d.rad", {"samples": 20}),
    ("script", "-r '-ab 5' -r '-ad 100' d.rad", {"rcontrib": ["-ab", "5", "-ad", "100"]}),
    ("script", "-s 'Manufacturer=A B;Foo=bar' d.rad", {"fields": {"Manufacturer": "A B", "Foo": "bar"}}),
    ("script", "-dimensions -1 1 -1 1 -.5 0 d.rad", {"dim": (-1, 1, -1, 1, -0.5, 0)}),
    ("script", "d.rad +f", {"files": ["d.rad", "+f"], "forward": False}),
    ("script", "-n 2 - ", {"files": ["-"]}),
    # Ours.
    ("ours", "--engine radiance --seed=7 -t4 4 --allow-command gen --checkpoint d.state d.rad",
     {"engine": "radiance", "seed": 7, "allow_commands": ["gen"], "checkpoint": "d.state", "files": ["d.rad"]}),
]  # fmt: skip


@pytest.mark.parametrize(("source", "line", "expected"), COMMANDS, ids=[f"{s}: {c}"[:60] for s, c, _ in COMMANDS])
def test_real_command_lines_are_understood(source, line, expected):
    asked = vars(request(shlex.split(line)))
    # Options that say nothing here because the source always writes them, and the files.
    said = {"-n": "processes", "-c": "samples", "-dim": "dim", "-r": "rcontrib", "-t3": "rank", "-t4": "rank"}
    free = {"files", "log2_res", *(name for option, name in said.items() if option in line)}
    assert expected.items() <= asked.items()
    for name, value in vars(Request()).items():
        if name not in expected and name not in free:
            assert asked[name] == value, name


def test_defaults_are_genbsdfs():
    asked = request(["d.rad"])
    assert (asked.samples, asked.processes, asked.rank, asked.cull_percent) == (2000, 1, 0, 90.0)
    assert (asked.forward, asked.backward, asked.color, asked.average) == (False, True, False, True)
    assert (asked.mgf, asked.geometry, asked.unit, asked.dim) == (False, True, "meter", None)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("-x d.rad", "no option -x"),
        ("+q d.rad", "no option +q"),
        ("+d 0 1 0 1 0 1 d.rad", "no option +d"),
        ("-h", "no option -h"),
        ("-c", "-c is followed by nothing"),
        ("-c many d.rad", "expected an integer"),
        ("-c 0 d.rad", "at least 1"),
        ("-t4 x d.rad", "expected an integer"),
        ("-t5 4 d.rad", "no option -t5"),
        ("-t 100 d.rad", "must be < 100"),
        ("-geom furlong d.rad", "Illegal geometry unit 'furlong'"),
        ("-geom d.rad", "Illegal geometry unit 'd.rad'"),
        ("-dim 0 1 0 1 d.rad", "expected a number"),
        ("-dim 0 1 0 1 -1", "-dim is followed by nothing"),
        ("-dim 0 1 0 1 -1 nan d.rad", "expected a number"),
        ("-f -b d.rad", "Must have at least one of +forward or +backward"),
        ("-s xyzzy d.rad", "bad tag name in assignment 'xyzzy'"),
        ("-s =x d.rad", "bad tag name"),
        ('-r "\'-ab 5" d.rad', "No closing quotation"),
        ("--engine embree d.rad", "expected bsdftree or radiance"),
        ("--sharpen d.rad", "no option --sharpen"),
    ],
)
def test_what_is_not_understood_is_said(line, message):
    with pytest.raises(UsageError) as error:
        request(shlex.split(line))
    assert message in str(error.value)
