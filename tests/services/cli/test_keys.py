"""`tandem keys`: what is made, kept and made anew, and whose the files are."""

from __future__ import annotations

import datetime
import os
import shutil
import stat
from pathlib import Path

import pytest
from cryptography import x509

from tests.services.cli.command import tandem_here


@pytest.fixture
def keys(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Keys:
    return Keys(tmp_path / "keys", capsys)


class Keys:
    """A folder of keys, and the command that makes them."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder, self._capsys = folder, capsys

    def make(self, *options: str) -> str:
        """What the command says, which succeeds."""
        done = tandem_here(self._capsys, "keys", str(self.folder), *options)
        assert done.returncode == 0, done.stderr
        assert done.stdout.count("\n") == 1
        return done.stdout

    def refused(self, *options: str) -> str:
        """What it says when it refuses."""
        done = tandem_here(self._capsys, "keys", str(self.folder), *options)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        return done.stderr

    def held(self) -> dict[str, bytes]:
        """Every file, by its path."""
        return {str(path.relative_to(self.folder)): path.read_bytes() for path in self.folder.rglob("*.pem")}

    def changed(self, *options: str) -> tuple[set[str], str]:
        """Whose folders have another certificate after the command, and what it said."""
        before = self.held()
        said = self.make(*options)
        after = self.held()
        assert before.keys() <= after.keys()
        return {path.split("/")[0] for path in after if after[path] != before.get(path)}, said

    def days(self, owner: str) -> float:
        """How long somebody's certificate is valid [days]."""
        certificate = x509.load_pem_x509_certificate((self.folder / owner / "certificate.pem").read_bytes())
        return (certificate.not_valid_after_utc - datetime.datetime.now(datetime.UTC)) / datetime.timedelta(days=1)


def test_they_are_made_once(keys: Keys) -> None:
    assert "made an authority, and certificates for router, sim, mock, " in keys.make()
    changed, said = keys.changed()
    assert not changed
    assert said.startswith("nothing to do for router, sim, ")
    for path in keys.folder.rglob("*"):
        mode = 0o700 if path.is_dir() else 0o600 if path.name == "key.pem" else 0o644
        assert stat.S_IMODE(path.stat().st_mode) == mode, path


def test_only_some_are_made_and_the_environment_names_them_too(keys: Keys, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TANDEM_KEYS", "router wrench")
    assert "for router, wrench;" in keys.make()
    assert {path.name for path in keys.folder.iterdir()} == {"authority", "router", "wrench"}
    changed, said = keys.changed("--only", "base")
    assert changed == {"base"} and "made certificates for base;" in said


def test_what_ends_soon_is_renewed_and_nothing_else(keys: Keys) -> None:
    keys.make("--only", "router", "--only", "base", "--days", "100")
    keys.make("--only", "wrench", "--days", "30")
    # A certificate is renewed when less than a third of the time is left that it is wanted for.
    assert keys.changed("--only", "router", "--only", "wrench", "--days", "89")[0] == {"router"}
    changed, said = keys.changed("--only", "base", "--only", "wrench", "--days", "100")
    assert changed == {"wrench"} and "made certificates for wrench (was to end on 20" in said
    assert keys.days("wrench") == pytest.approx(100.0, abs=0.1)


def test_what_is_missing_broken_or_lacks_a_name_is_made_anew(keys: Keys) -> None:
    keys.make()
    (keys.folder / "sim" / "certificate.pem").unlink()
    (keys.folder / "mock" / "key.pem").write_text("nonsense")
    shutil.copy(keys.folder / "base" / "key.pem", keys.folder / "task" / "key.pem")
    changed, said = keys.changed()
    assert changed == {"sim", "mock", "task"}
    assert "for sim, mock (was broken), task (was broken);" in said
    changed, said = keys.changed("--only", "router", "--name", "192.0.2.7", "--name", "robot.example")
    assert changed == {"router"} and "router (did not name 192.0.2.7, robot.example)" in said
    assert keys.changed() == (set(), keys.make())


def test_one_is_made_anew_when_it_is_asked_for(keys: Keys) -> None:
    keys.make()
    assert keys.changed("--renew", "--only", "wrench")[0] == {"wrench"}


def test_one_is_made_for_elsewhere(keys: Keys, tmp_path: Path) -> None:
    keys.make("--only", "operator")
    changed, _ = keys.changed("--only", "operator", "--into", str(tmp_path / "laptop"), "--days", "30")
    assert not changed
    held = {path.name: path.read_bytes() for path in (tmp_path / "laptop").iterdir()}
    assert held.keys() == {"authority.pem", "certificate.pem", "key.pem"}
    assert held["authority.pem"] == (keys.folder / "operator" / "authority.pem").read_bytes()
    assert "--into x: wanted one --only, got operator, viewer" in keys.refused(
        "--only", "operator", "--only", "viewer", "--into", "x"
    )


def test_a_new_authority_makes_all_anew_and_so_does_a_lost_one(keys: Keys) -> None:
    keys.make("--only", "router", "--only", "sim")
    assert keys.changed("--revoke", "--only", "router")[0] == {"authority", "router"}
    changed, said = keys.changed("--only", "router", "--only", "sim")
    assert changed == {"sim"} and "sim (was another authority's)" in said
    (keys.folder / "authority" / "key.pem").unlink()
    assert keys.changed("--only", "router", "--only", "sim")[0] == {"authority", "router", "sim"}


def test_another_robot_s_are_not_overwritten_unasked(keys: Keys) -> None:
    keys.make("--only", "viewer")
    said = keys.refused("--only", "viewer", "--robot", "reem")
    assert "viewer is tiago.viewer's, not reem.viewer's: choose another folder, or --renew" in said
    assert keys.changed("--only", "viewer", "--robot", "reem", "--renew")[0] == {"viewer"}


def test_what_cannot_be_made_is_refused_with_one_line(keys: Keys) -> None:
    assert "--only moon: choose from router, sim" in keys.refused("--only", "moon")
    keys.folder.write_text("a file")
    assert f"{keys.folder}: File exists" in keys.refused()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root makes files of somebody else")
def test_they_belong_to_whoever_owns_the_folder(keys: Keys) -> None:
    for owner, number in (("router", 12345), ("wrench", 12346)):
        (keys.folder / owner).mkdir(parents=True)
        os.chown(keys.folder / owner, number, number)
    keys.make("--only", "router", "--only", "wrench", "--only", "base")
    owners = {path.parent.name: path.stat().st_uid for path in keys.folder.rglob("*.pem")}
    assert owners == {"authority": 0, "router": 12345, "wrench": 12346, "base": 0}
