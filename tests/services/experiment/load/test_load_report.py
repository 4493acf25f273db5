"""The report's folder holds everything that it promises, and the page shows what was found."""

from __future__ import annotations

import copy
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from services.experiment.experiments import report
from services.experiment.load.load import LOAD, film_data
from services.experiment.main import main
from services.experiment.play.recording import RECORDING, Recording
from services.experiment.report.report import write
from services.sim.film import film
from shared.loop.config import Misconfigured
from tests.services.experiment.load import defects
from tests.services.experiment.load.defects import Defect

RUNS = ("paper-30", "certified-30", "certified-100", "rounded-100")


def put(folder: Path, name: str, played_file: Path) -> None:
    """The recording under the name of some run."""
    (folder / name).mkdir(parents=True)
    shutil.copy(played_file, folder / name / RECORDING)


def spoilt(played: Recording, *spoil: Defect) -> Recording:
    recording = copy.deepcopy(played)
    for defect in spoil:
        defect(recording)
    return recording


@pytest.fixture(scope="module")
def folder(played_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report")
    for name in RUNS:
        put(path, name, played_file)
    assert main(["report", str(path), "--ran", "tandem run load <here>"]) == 0
    return path


def test_the_page_stands_alone_and_its_links_lead_somewhere(folder: Path) -> None:
    page = (folder / "index.html").read_text()
    assert not re.search(r"(src|href)=\"(https?:)?//", page)
    links = re.findall(r"href=\"([^\"]+)\"", page)
    assert len(links) >= len(RUNS)
    assert all((folder / link).exists() for link in links)
    assert page.count("data:image/svg+xml;base64,") == 2 + len(RUNS)
    assert "tandem run load &lt;here&gt;" in page
    assert "claims hold" in page


def test_every_claim_stands_on_the_page(folder: Path) -> None:
    page = (folder / "index.html").read_text()
    claims = json.loads((folder / "claims.json").read_text())["claims"]
    assert {claim["run"] for claim in claims} >= set(RUNS)
    assert all(claim["figure"] in page for claim in claims)
    assert page.count("✓ pass") == len(claims)


def test_an_experiment_without_tables_says_so(folder: Path) -> None:
    assert json.loads((folder / "claims.json").read_text())["tables"] == []


def test_every_figure_is_there_in_both_formats(folder: Path) -> None:
    names = {"comparison", "lowering", *RUNS}
    for suffix in (".svg", ".png"):
        assert {path.stem for path in (folder / "figures").glob(f"*{suffix}")} == names


def test_a_failed_claim_fails_the_command_and_is_marked(played: Recording, tmp_path: Path) -> None:
    assert not write(LOAD, {"certified-100": spoilt(played, defects.bounces)}, tmp_path).good
    page = (tmp_path / "index.html").read_text()
    assert "✗ fail" in page
    assert re.search(r"1 of \d+ claims fail", page)


def test_brakes_are_told_in_the_table_and_grey_in_the_figure(played: Recording, tmp_path: Path) -> None:
    assert write(LOAD, {"certified-100": spoilt(played, defects.braked)}, tmp_path).good
    page = (tmp_path / "index.html").read_text()
    assert "3 brakes: no fresh command" in page
    assert "Grey: a brake" in page
    summary = json.loads((tmp_path / "claims.json").read_text())
    brakes = summary["measures"]["certified-100"]["brakes"]
    assert [brake["reason"] for brake in brakes] == ["no fresh command"] * 3


def test_a_run_that_did_not_finish_fails_the_command_but_not_the_others(played: Recording, tmp_path: Path) -> None:
    runs = {"paper-30": spoilt(played, defects.broken_off), "certified-30": played}
    assert not write(LOAD, runs, tmp_path).good
    summary = json.loads((tmp_path / "claims.json").read_text())
    assert {claim["run"] for claim in summary["claims"]} == {"certified-30"}
    assert summary["problems"][0].startswith("paper-30 is not judged")


def test_a_machine_that_stalled_is_named(played: Recording, tmp_path: Path) -> None:
    problems = write(LOAD, {"paper-30": spoilt(played, defects.stalled), "certified-30": played}, tmp_path).problems
    assert len(problems) == 1
    assert problems[0].startswith("paper-30: the force sensor was silent for up to 15")


def refuse(*_: object) -> None:
    raise Misconfigured("series of one length")


def test_a_film_that_cannot_be_made_is_told_and_the_report_does_without(
    played_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    put(tmp_path, "certified-100", played_file)
    monkeypatch.setattr(film, "render", refuse)
    assert main(["film", str(tmp_path / "certified-100")]) == 1
    assert "no film: series of one length" in capsys.readouterr().out
    assert "<video" not in report(tmp_path).index.read_text()


def test_a_film_is_shown_on_the_page(played_file: Path, tmp_path: Path) -> None:
    put(tmp_path, "certified-100", played_file)
    (tmp_path / "certified-100" / film.FILM).write_bytes(b"film")
    assert 'src="certified-100/scene.mp4"' in report(tmp_path).index.read_text()


def test_film_data_are_on_one_time_base(played: Recording) -> None:
    data = film_data(played)
    assert data["time"][0] >= 0.0
    for name in ("joint_positions", "bag_mass", "bag_height", "force_z", "limit_z"):
        assert len(data[name]) == len(data["time"])
    assert data["joint_positions"].shape[1] == len(data["joint_names"])
    assert data["bag_mass"][np.searchsorted(data["time"], 15.0)] == pytest.approx(20.0 / 9.81)
    assert data["bag_mass"][np.searchsorted(data["time"], 5.0)] == 0.0


def test_an_empty_folder_is_refused_with_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 2
    assert "no recording of any run" in capsys.readouterr().err
