"""A file is written whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from shared.loop.files import default_folder, write_whole


def test_written_whole_in_a_new_folder(tmp_path: Path) -> None:
    path = tmp_path / "new" / "state.json"
    write_whole(path, "one")
    write_whole(path, "two")
    assert path.read_text() == "two"
    assert list(path.parent.iterdir()) == [path], "nothing is left beside it"


def test_failure_leaves_the_file_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(OSError):
        write_whole(tmp_path / "file" / "state.json", "text")
    assert (tmp_path / "file").read_text() == "no folder"


def test_folder_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", "/var/state")
    assert default_folder() == Path("/var/state/tandem")
