"""`bsdftree view`: what the server answers and refuses, what the exported page holds, what is said at the prompt.

That browsers understand both is the business of web/tests."""

import base64
import gzip
import hashlib
import http.client
import re
import signal
import socket
import subprocess
import sys
import urllib.parse

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree._viewer import built as building
from bsdftree._viewer.exhibit import exhibits
from bsdftree._viewer.server import HEADERS
from bsdftree.cli import main

# Stands for what `make web` builds, as far as the server and the export are concerned.
PAGE = {
    "index.html": """<!doctype html><html><head>
<meta
  http-equiv="Content-Security-Policy"
  content="default-src 'none'"
/>
<link rel="stylesheet" href="./style.css" />
<script type="module" src="./main.js"></script>
</head><body></body></html>
""",
    "main.js": r'const line = "\n\1 \g<0>";',
    "style.css": "body { margin: 0; }\n",
    "core-ABC.wasm": "\0asm and so on",
}


@pytest.fixture(autouse=True)
def page(tmp_path, monkeypatch):
    folder = tmp_path / "page"
    folder.mkdir()
    for name, text in PAGE.items():
        (folder / name).write_text(text)
    (folder / "notes.txt").write_text("not of the page")
    monkeypatch.setattr(building, "_PAGE", folder)
    return folder


@pytest.fixture
def white():
    return bsdftree.Bsdf.from_trees({"reflection_back": bsdftree.Tree.from_grid(np.full((2, 2, 2, 2), 0.25))})


@pytest.fixture
def files(white, tmp_path):
    paths = [tmp_path / "a" / "white & more.xml", tmp_path / "b" / "white & more.xml", tmp_path / "packed.bsdft"]
    for path in paths:
        path.parent.mkdir(exist_ok=True)
        white.save(path)
    return paths


@pytest.fixture
def run():
    return lambda *args: CliRunner().invoke(main, ["view", *map(str, args)])


def ask(viewer, path, method="GET", **headers):
    """Send a path as it stands, which urllib would tidy up."""
    connection = http.client.HTTPConnection(urllib.parse.urlsplit(viewer.url).netloc, timeout=10)
    try:
        connection.putrequest(method, path, skip_host="Host" in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, dict(answer.headers), answer.read()
    finally:
        connection.close()


def test_page_and_files_are_served_with_their_types(files):
    with bsdftree.view(*files, browser=False) as viewer:
        kinds = {
            "index.html": "text/html",
            "main.js": "text/javascript",
            "style.css": "text/css",
            "core-ABC.wasm": "application/wasm",
        }
        for name, kind in kinds.items():
            status, headers, content = ask(viewer, f"/{name}")
            assert (status, content) == (200, PAGE[name].encode())
            assert headers["Content-Type"].partition(";")[0] == kind
        status, headers, _ = ask(viewer, "/")
        assert status == 302
        # What the page makes of its address.
        named = urllib.parse.parse_qs(headers["Location"].partition("?")[2])["file"]
        assert [urllib.parse.unquote(name) for name in named] == [
            "files/a/white & more.xml", "files/b/white & more.xml", "files/packed.bsdft",
        ]  # fmt: skip
        for name, path in zip(named, files, strict=True):
            status, headers, content = ask(viewer, f"/{name}")
            assert (status, content) == (200, path.read_bytes())
            assert headers["Content-Type"] == "application/octet-stream"
            assert int(headers["Content-Length"]) == len(content)
            assert ask(viewer, f"/{name}", "HEAD")[2] == b""


def test_every_answer_has_the_policy_and_forbids_guessing(files):
    with bsdftree.view(files[0], browser=False) as viewer:
        for path in ("/", "/index.html", "/main.js", "/nothing", "/files/white%20&%20more.xml"):
            _, headers, _ = ask(viewer, path)
            assert HEADERS.items() <= headers.items()
        assert "connect-src 'self'" in headers["Content-Security-Policy"]
        assert "Access-Control-Allow-Origin" not in headers


@pytest.mark.parametrize(
    "path",
    [
        "/files/", "/files", "/notes.txt", "/../page/notes.txt", "/files/../notes.txt", "/files/%2e%2e/notes.txt",
        "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/etc/passwd", "/files//etc/passwd",
        "/files/b/white%20&%20more.xml", "main.js", "/main.js/", "/main.js%00", "*",
    ],
)  # fmt: skip
def test_nothing_else_of_the_disk_is_served(files, path):
    with bsdftree.view(files[0], browser=False) as viewer:
        status, _, content = ask(viewer, path)
        assert (status, content) == (404, b"nothing of that name is served\n")


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1:1", "localhost.evil.example:{port}", ""]
)
def test_names_of_other_hosts_are_refused(files, host):
    with bsdftree.view(files[0], browser=False) as viewer:
        port = urllib.parse.urlsplit(viewer.url).port
        assert ask(viewer, "/main.js", Host=host.format(port=port))[0] == 421
        assert ask(viewer, "/main.js", Host=f"localhost:{port}")[0] == 200


def test_only_reading_is_understood(files):
    with bsdftree.view(files[0], browser=False) as viewer:
        for method in ("POST", "PUT", "DELETE", "OPTIONS"):
            assert ask(viewer, "/", method)[0] == 501


def test_it_listens_on_loopback_alone_and_ends(white):
    viewer = bsdftree.view(white, browser=False)
    port = urllib.parse.urlsplit(viewer.url).port
    assert viewer._server._served.server_address == ("127.0.0.1", port)
    viewer.close()
    viewer.close()
    viewer.wait()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port), timeout=5)


def test_files_are_read_anew_and_may_go(files):
    path = files[2]
    with bsdftree.view(path, browser=False) as viewer:
        path.unlink()
        status, _, content = ask(viewer, "/files/packed.bsdft")
        assert status == 410
        assert b"No such file" in content
        path.write_bytes(b"newer")
        assert ask(viewer, "/files/packed.bsdft")[2] == b"newer"


def test_bsdfs_in_memory_get_names_of_their_own(white, tmp_path):
    shown = exhibits([white, white])
    assert [exhibit.name for exhibit in shown] == ["BSDF", "BSDF (2)"]
    with white.view(browser=False) as viewer:
        path = tmp_path / "got.bsdft"
        path.write_bytes(ask(viewer, "/files/BSDF")[2])
    assert bsdftree.load(path).to_xml() == white.to_xml()


def test_the_same_file_is_shown_once_and_in_the_order_given(white, files):
    shown = exhibits([files[2], white, files[0], files[2]])
    assert [exhibit.path for exhibit in shown] == [files[2], None, files[0]]


def blocks(html):
    found = re.findall(r'<script type="application/octet-stream" data-(\w+)="([^"]*)">([^<]*)</script>', html)
    return [(kind, name, gzip.decompress(base64.b64decode(text, validate=True))) for kind, name, text in found]


def test_an_exported_page_holds_everything_and_asks_for_nothing(run, files, white, tmp_path):
    out = tmp_path / "out.html"
    result = run(*files, "--export", out)
    assert result.exit_code == 0, result.output
    html = out.read_text()
    assert not re.search(r"\b(src|href)=", html)
    policy = re.search(r'Content-Security-Policy"\s+content="([^"]*)"', html)[1]
    for tag in ("style", 'script type="module"'):
        inside = re.search(f"<{tag}>(.*?)</{tag.split()[0]}>", html, re.DOTALL)[1]
        hashed = base64.b64encode(hashlib.sha256(inside.encode()).digest()).decode()
        assert f"{tag.split()[0]}-src 'sha256-{hashed}'" in policy
    assert "unsafe-inline" not in policy and "connect-src" not in policy and "default-src 'none'" in policy
    (core, *held) = blocks(html)
    assert core == ("core", "core", PAGE["core-ABC.wasm"].encode())
    assert [name for _, name, _ in held] == ["a/white &amp; more.xml", "b/white &amp; more.xml", "packed.bsdft"]
    for _, _, content in held:
        packed = tmp_path / "held.bsdft"
        packed.write_bytes(content)
        assert bsdftree.load(packed).to_xml() == white.to_xml()
    assert run(*files, "--export", tmp_path / "again.html").exit_code == 0
    assert (tmp_path / "again.html").read_bytes() == out.read_bytes()


def test_names_cannot_end_their_place_in_an_exported_page(white, tmp_path):
    path = tmp_path / '"><script>x.xml'
    white.save(path)
    bsdftree.save_view(tmp_path / "out.html", path)
    html = (tmp_path / "out.html").read_text()
    assert [name for _, name, _ in blocks(html)] == ["core", "&quot;&gt;&lt;script&gt;x.xml"]
    assert "<script>" not in html


def test_damaged_files_are_shown_as_they_are_and_told(run, white, tmp_path):
    source = tmp_path / "old.xml"
    sheet = bsdftree.Bsdf.from_trees({"transmission_back": white.components["reflection_back"]})
    source.write_text(sheet.to_xml().replace("Transmission Back", "Transmission"))
    out = tmp_path / "out.html"
    result = run(source, "--export", out)
    assert result.exit_code == 0, result.output
    assert f"{source.name}: " in result.stderr
    assert blocks(out.read_text())[1][2] == source.read_bytes()


def test_what_is_no_bsdf_is_told_before_anything_is_served(run, files, tmp_path):
    broken = tmp_path / "broken.xml"
    broken.write_text("<html/>")
    for options in ((), ("--export", tmp_path / "out.html")):
        result = run(files[0], broken, *options)
        assert result.exit_code == 1
        assert "broken.xml" in result.stderr and "html" in result.stderr and not result.stdout
        result = run(files[0], tmp_path / "absent.xml", *options)
        assert result.exit_code == 1 and "absent.xml" in result.stderr
    assert not list(tmp_path.glob("*out.html*"))


def test_an_export_that_cannot_be_written_leaves_nothing(run, files, tmp_path):
    result = run(files[0], "--export", tmp_path / "none" / "out.html")
    assert result.exit_code == 1 and "out.html" in result.stderr
    assert run(files[0], "--export", tmp_path / "x.html", "--port", 8000).exit_code == 2


def test_a_port_that_is_taken_is_told(run, files):
    with bsdftree.view(files[0], browser=False) as viewer:
        port = urllib.parse.urlsplit(viewer.url).port
        result = run(files[0], "--no-browser", "--port", port)
    assert result.exit_code == 1
    assert f"port {port} is taken" in result.stderr


def test_without_the_built_page_it_says_how_to_build(run, files, page):
    for path in page.iterdir():
        path.unlink()
    result = run(files[0], "--no-browser")
    assert result.exit_code == 1 and "make web" in result.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT is that of consoles there")
def test_it_prints_its_address_and_ends_quietly_on_interrupt(files, page):
    program = f"""
from pathlib import Path
from bsdftree._viewer import built
built._PAGE = Path({str(page)!r})
from bsdftree.cli import main
main(["view", {str(files[0])!r}, "--no-browser"])
"""
    process = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        address = process.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", address)
        parts = urllib.parse.urlsplit(address)
        connection = http.client.HTTPConnection(parts.netloc, timeout=10)
        connection.request("GET", "/")
        assert connection.getresponse().status == 302
        connection.close()
        process.send_signal(signal.SIGINT)
        rest, said = process.communicate(timeout=20)
    finally:
        process.kill()
    assert process.returncode == 0
    # The signal may come before the hint.
    assert rest == "" and said.split() in ([], ["Ctrl-C", "ends", "it"])
