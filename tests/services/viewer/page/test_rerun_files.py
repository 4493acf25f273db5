"""The files of rerun's page as its package has them, without what they would fetch from elsewhere."""

from __future__ import annotations

import gzip
import importlib.metadata
import importlib.util
import re
import subprocess
from pathlib import Path

import pytest

from services.viewer.page import rerun_files
from services.viewer.page.rerun_files import INDEX, PROGRAM, SCRIPT, Missing, files


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path


def test_they_are_taken_out_once_and_name_no_other_host(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = files()
    assert folder.is_relative_to(cache) and importlib.metadata.version("rerun-sdk") in folder.name
    for name in (SCRIPT, PROGRAM):
        content = gzip.decompress((folder / f"{name}.gz").read_bytes())
        assert len(content) == int((folder / f"{name}.size").read_text())
        assert name == SCRIPT or content.startswith(b"\0asm")
    index = (folder / INDEX).read_text()
    assert f'src="{SCRIPT}"' in index
    # What a browser fetches by itself.
    assert not re.search(r"<(?:link|script|img)\b[^>]*https?://", index)
    assert [path.name for path in folder.parent.iterdir()] == [folder.name], "nothing half made is left"

    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: pytest.fail("they are there already"))
    assert files() == folder


def test_another_package_than_the_one_that_is_known_is_told(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rerun_files, "_fetch", lambda: {INDEX: b"<html>", SCRIPT: b"", PROGRAM: b""})
    with pytest.raises(Missing, match=r"not those of the version that is known here \(0\.41\.0\)"):
        files()
    assert not list((cache / "tandem").iterdir())


def test_a_program_that_does_not_run_is_told(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setenv("PATH", str(cache))
    with pytest.raises(Missing, match="rerun's own viewer is not installed"):
        files()


def test_without_the_package_the_remedy_is_named(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> str:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", absent)
    with pytest.raises(Missing, match=r"pip install '\.\[viewer\]' in its checkout"):
        files()
