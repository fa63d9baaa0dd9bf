"""The page with everything inside, for ``file://``: looks, program, core and BSDFs in one HTML text.

Modules in files of their own do not load from ``file://``, nor does ``fetch`` work there; so program and looks stand in
the page, and core and BSDFs in blocks of data that ``web/src/inside.ts`` reads: gzip as base64. The content security
policy names program and looks by their hashes and allows no connection at all.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from pathlib import Path

from bsdftree._viewer.exhibit import Exhibit

_POLICY = re.compile(r'(http-equiv="Content-Security-Policy"\s+content=)"[^"]*"')
_LOOKS = re.compile(r'<link rel="stylesheet" href="\./style\.css"\s*/?>')
_PROGRAM = re.compile(r'<script type="module" src="\./main\.js"></script>')
_END = re.compile(r"(?=</body>)")


def one_page(page: Mapping[str, Path], files: Iterable[Exhibit]) -> Iterator[bytes]:
    """Return the page in pieces, one for each file, so that memory is that of the largest."""
    looks, program = (page[name].read_text(encoding="utf-8") for name in ("style.css", "main.js"))
    # What would end the block early, or begin another in it; esbuild writes none.
    assert not re.search(r"</style|</script|<!--|<script", looks + program, re.IGNORECASE)
    policy = (
        f"default-src 'none'; script-src {_hash(program)} 'wasm-unsafe-eval'; style-src {_hash(looks)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    html = page["index.html"].read_text(encoding="utf-8")
    html = _replaced(_POLICY, html, rf'\1"{policy}"')
    html = _replaced(_LOOKS, html, f"<style>{looks}</style>")
    html = _replaced(_PROGRAM, html, f'<script type="module">{program}</script>')
    before, after = _END.split(html)
    (core,) = (path for name, path in page.items() if name.endswith(".wasm"))
    yield before.encode()
    yield _block("core", "core", core.read_bytes())
    for file in files:
        yield _block("bsdf", file.name, file.packed())
    yield after.encode()


def _replaced(pattern: re.Pattern[str], text: str, by: str) -> str:
    # Programs are full of backslashes; only the policy's has a meaning.
    result, n = pattern.subn((lambda match: match.expand(by)) if by.startswith(r"\1") else (lambda _: by), text)
    assert n == 1, f"the page has {n} of {pattern.pattern}"
    return result


def _block(kind: str, name: str, content: bytes) -> bytes:
    # mtime 0: the same files make the same page.
    text = base64.b64encode(gzip.compress(content, 6, mtime=0))
    head = f'<script type="application/octet-stream" data-{kind}="{escape(name, quote=True)}">'
    return head.encode() + text + b"</script>\n"


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
