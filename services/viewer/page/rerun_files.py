"""The files of rerun's page, taken out of its package once: by ``python rerun_files.py`` when an image is built.

The package holds them inside its programs only. One of these serves them on loopback for the moment that it takes to
fetch them. What they would fetch from elsewhere is taken out, and the large ones are packed. The standard library alone
is imported: an image has these files before it has any code.
"""

from __future__ import annotations

import gzip
import importlib.metadata
import importlib.util
import os
import re
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.request
from pathlib import Path

INDEX, SCRIPT, PROGRAM = "index.html", "re_viewer.js", "re_viewer_bg.wasm"
"""All of them; the last two are kept with gzip."""
_WITHIN = 60.0  # [s] on a busy machine
_OUTSIDE = re.compile(r"<link\b[^>]*?(?:\brel=\"(?:icon|apple-touch-icon)\"|https?://)[^>]*>", re.DOTALL)
"""Fonts of another host, and icons that are not there."""


class Missing(Exception):
    """They are not to be had; the text is one line."""


def files() -> Path:
    """The folder that they are in, made if it is not there.

    Raises:
        Missing: the package is not installed, or is another one than was known when this was written.
    """
    try:
        version = importlib.metadata.version("rerun-sdk")
    except importlib.metadata.PackageNotFoundError:
        raise Missing("rerun-sdk is not installed: pip install '.[viewer]' in its checkout") from None
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = cache / "tandem" / f"rerun-{version}"
    if not folder.is_dir():
        try:
            _make(folder)
        except OSError as problem:
            raise Missing(f"the files of rerun's page: {problem}") from None
    return folder


def _make(folder: Path) -> None:
    folder.parent.mkdir(parents=True, exist_ok=True)
    made = Path(tempfile.mkdtemp(dir=folder.parent))
    made.chmod(0o755)
    try:
        fetched = _fetch()
        index = _OUTSIDE.sub("", fetched[INDEX].decode())
        if "fonts.g" in index or '<script src="re_viewer.js">' not in index:
            raise Missing("the files of rerun's page are not those of the version that is known here (0.41.0)")
        (made / INDEX).write_text(index)
        for name in (SCRIPT, PROGRAM):
            with (made / f"{name}.gz").open("wb") as raw, gzip.GzipFile(name, "wb", 6, raw, mtime=0) as packed:
                packed.write(fetched[name])
            (made / f"{name}.size").write_text(str(len(fetched[name])))
        if not folder.is_dir():
            made.rename(folder)
    finally:
        shutil.rmtree(made, ignore_errors=True)


def program() -> Path:
    """Rerun's own program, not the command of that name, which is a parent that leaves it running.

    Raises:
        Missing: it is not there, as in an image, which does without once it has the files.
    """
    found = importlib.util.find_spec("rerun_cli")
    for folder in (found.submodule_search_locations or ()) if found else ():
        if (path := Path(folder) / "rerun").exists():
            return path
    raise Missing("rerun's own viewer is not installed: pip install '.[viewer]' in its checkout")


def _fetch() -> dict[str, bytes]:
    """Each file as rerun's own program serves it."""
    own = program()
    grpc, page = _free_port(), _free_port()
    options = ("--serve-web", "--bind", "127.0.0.1", "--port", str(grpc), "--web-viewer-port", str(page))
    # With CI it reports nothing to its makers. A display it does not need.
    server = subprocess.Popen(
        [own, *options], env={**os.environ, "CI": "1"}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        deadline = time.monotonic() + _WITHIN
        while not _listens(page):
            if server.poll() is not None or time.monotonic() > deadline:
                raise Missing(f"{own} does not serve the files of its page")
            time.sleep(0.05)
        direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        return {
            name: direct.open(f"http://127.0.0.1:{page}/{name}", timeout=_WITHIN).read()
            for name in (INDEX, SCRIPT, PROGRAM)
        }
    finally:
        server.terminate()
        server.wait()


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        return int(probe.getsockname()[1])


if __name__ == "__main__":
    print(files())
