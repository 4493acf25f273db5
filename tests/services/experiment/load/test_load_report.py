"""The report's folder holds everything that it promises, and the page shows what was found."""

from __future__ import annotations

import copy
import json
import re
import shutil
from pathlib import Path

import pytest

from services.experiment.experiments import report
from services.experiment.load.load import LOAD, parts
from services.experiment.load.load_figures import Frame, draw_run
from services.experiment.load.load_measures import measure
from services.experiment.main import main
from services.experiment.play.recording import RECORDING, Recording
from services.experiment.report.report import NOT_JUDGED, write
from services.viewer import film
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


def test_a_failed_claim_fails_the_command_and_is_marked_where_its_run_is_open(
    played: Recording, tmp_path: Path
) -> None:
    runs = {"certified-100": spoilt(played, defects.bounces), "certified-30": played}
    found = write(LOAD, runs, tmp_path)
    assert found.status == 1 and re.fullmatch(r"1 of \d+ claims fail", found.verdict)
    page = (tmp_path / "index.html").read_text()
    failing, holding = (
        re.search("<details open>.*?</details>", page, re.S),
        re.search("<details>.*?</details>", page, re.S),
    )
    assert failing and holding and page.count("<details") == 2
    assert "✗ fail" in failing[0] and "(certified-100)" in failing[0] and found.verdict in page
    assert "✗ fail" not in holding[0] and "(certified-30)" in holding[0]


def test_what_fails_on_a_machine_that_was_too_busy_is_not_judged(played: Recording, tmp_path: Path) -> None:
    busy = spoilt(played, defects.bounces, defects.late)
    found = write(LOAD, {"certified-30": busy, "paper-30": played}, tmp_path)
    assert found.status == NOT_JUDGED
    # What fails in it, and the three comparisons with it.
    assert found.count("not judged") == 4 and found.count("fail") == 0
    assert found.verdict == f"4 of {len(found.claims)} claims not judged: the machine was too busy"
    assert "5.0 % of the steps of sim were late (bound 2 %)" in found.busy["certified-30"]
    page, summary = (tmp_path / "index.html").read_text(), json.loads((tmp_path / "claims.json").read_text())
    assert page.count("– not judged") == 4 and '<p class="verdict open">' in page
    assert summary["status"] == NOT_JUDGED and summary["late_steps"]["certified-30"]["sim"] > 0.04
    failing = spoilt(played, defects.bounces)
    assert write(LOAD, {"certified-30": busy, "certified-100": failing}, tmp_path).status == 1


def test_what_holds_on_a_machine_that_was_too_busy_counts(played: Recording, tmp_path: Path) -> None:
    found = write(LOAD, {"certified-100": spoilt(played, defects.late)}, tmp_path)
    assert (found.status, found.verdict) == (0, f"all {len(found.claims)} claims hold")
    assert found.problems[0].startswith("certified-100: the machine was too busy")


def test_what_could_not_be_measured_is_null_for_programs(played: Recording, tmp_path: Path) -> None:
    write(LOAD, {"certified-100": spoilt(played, defects.never_lowers)}, tmp_path)
    summary = json.loads((tmp_path / "claims.json").read_text(), parse_constant=pytest.fail)
    assert summary["measures"]["certified-100"]["landing"] is None


def test_the_page_tells_a_story(folder: Path) -> None:
    page = (folder / "index.html").read_text()
    parts = [
        'class="verdict pass"',
        "certified, 100 Hz</b>: holds 20 N within 0.0 mm, lowers 28 N to the ground in ",
        "<h2>What happened</h2>",
        "All laws in the same test",
        "<h2>The comparison</h2>",
        "<h2>Run by run</h2>",
        "<details>",
        "<h2>How it was run</h2>",
        "load average at the start",
    ]
    places = [page.find(part) for part in parts]
    assert -1 not in places and places == sorted(places), dict(zip(parts, places, strict=True))


def test_figures_of_different_runs_have_the_same_scales(played: Recording) -> None:
    deep = spoilt(played, defects.moved(20.0, 25.0, -0.5))
    measured = measure(played)
    frame = Frame.of([played, deep])
    drawn = [draw_run(LOAD.run_named("certified-100"), one, measured, frame) for one in (played, deep)]
    scales = [[(*axes.get_xlim(), *axes.get_ylim()) for axes in figure.axes] for figure in drawn]
    assert scales[0] == scales[1]
    lowest = deep.series("state/ee", "position")[:, 2].min()
    assert frame.height[0] < lowest < played.series("state/ee", "position")[:, 2].min() - 0.1


def test_brakes_are_told_in_the_table_and_grey_in_the_figure(played: Recording, tmp_path: Path) -> None:
    assert write(LOAD, {"certified-100": spoilt(played, defects.braked)}, tmp_path).status == 0
    page = (tmp_path / "index.html").read_text()
    assert "3 brakes: no fresh command" in page
    assert "Grey: a brake" in page
    summary = json.loads((tmp_path / "claims.json").read_text())
    brakes = summary["measures"]["certified-100"]["brakes"]
    assert [brake["reason"] for brake in brakes] == ["no fresh command"] * 3


def test_a_run_that_did_not_finish_fails_the_command_but_not_the_others(played: Recording, tmp_path: Path) -> None:
    runs = {"paper-30": spoilt(played, defects.broken_off), "certified-30": played}
    assert write(LOAD, runs, tmp_path).status == 1
    summary = json.loads((tmp_path / "claims.json").read_text())
    assert {claim["run"] for claim in summary["claims"]} == {"certified-30"}
    assert summary["problems"][0].startswith("paper-30 is not judged")
    assert summary["verdict"].startswith("paper-30 was not played to its end; all ")


def test_a_run_that_a_busy_machine_broke_off_is_not_judged_and_its_film_is_shown(
    played: Recording, tmp_path: Path
) -> None:
    (tmp_path / "paper-30").mkdir()
    (tmp_path / "paper-30" / "scene.mp4").touch()
    runs = {"paper-30": spoilt(played, defects.broken_off, defects.late), "certified-30": played}
    found = write(LOAD, runs, tmp_path)
    assert found.status == NOT_JUDGED and found.count("not judged") == 0
    assert "the machine was too busy" in found.problems[0]
    assert 'src="paper-30/scene.mp4"' in (tmp_path / "index.html").read_text()


def test_a_machine_that_stalled_is_named(played: Recording, tmp_path: Path) -> None:
    problems = write(LOAD, {"paper-30": spoilt(played, defects.stalled), "certified-30": played}, tmp_path).problems
    assert len(problems) == 1
    assert re.search(r"^paper-30: the machine was too busy.*: the force sensor was silent for 15\d\d ms", problems[0])


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


def test_the_parts_are_the_bags(played: Recording) -> None:
    found = parts(played)
    assert [(part.name, round(part.start)) for part in found] == [("light", 10), ("heavy", 17), ("unload", 30)]
    assert [part.end for part in found[:-1]] == [part.start for part in found[1:]]
    assert found[1].caption == "28 N hang from it, more than its limit" and all(part.still for part in found)


def test_the_paper_s_law_is_on_the_left_of_the_filmed_run_alone(
    played_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[list[str]] = []
    monkeypatch.setattr(film, "render", lambda takes, folder: shown.append([take.path.parent.name for take in takes]))
    for name in ("certified-100", "paper-30", "certified-30"):
        put(tmp_path, name, played_file)
        assert main(["film", str(tmp_path / name)]) == 0
    assert main(["film", str(tmp_path / "certified-100")]) == 0
    (tmp_path / "paper-30" / RECORDING).write_bytes(b"damaged")
    assert main(["film", str(tmp_path / "certified-100")]) == 0
    assert shown == [
        ["certified-100"],
        ["paper-30"],
        ["certified-30"],
        ["paper-30", "certified-100"],
        ["certified-100"],
    ]


def test_an_empty_folder_is_refused_with_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 2
    assert "no recording of any run" in capsys.readouterr().err
