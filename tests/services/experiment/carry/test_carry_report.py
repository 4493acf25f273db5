"""The carry's folder holds everything that it promises, and the page shows what was found."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path

import pytest
from markupsafe import escape

from services.experiment.carry import carry_figures as figures
from services.experiment.carry.carry import CARRY
from services.experiment.carry.carry_figures import Frame
from services.experiment.carry.carry_measures import measure
from services.experiment.carry.carry_parts import STATES, recorded_parts
from services.experiment.carry.carry_tables import tables
from services.experiment.experiments import report
from services.experiment.play.recording import Recording
from services.experiment.report.report import write
from tests.services.experiment.carry import defects

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def folder(carried: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs; the paper's is the same recording under another name."""
    path = tmp_path_factory.mktemp("report")
    paper = copy.deepcopy(carried)
    paper.meta |= {"name": "paper-omni", "law": "paper"}
    (path / "certified-omni").mkdir()
    (path / "certified-omni" / "strip.png").write_bytes(b"strip")
    (path / "certified-omni" / "scene.mp4").write_bytes(b"film")
    assert write(CARRY, {"certified-omni": carried, "paper-omni": paper}, path, ["tandem run carry <here>"]).status == 0
    return path


def test_the_page_has_claims_figures_strip_and_film(folder: Path) -> None:
    page = (folder / "index.html").read_text()
    claims = json.loads((folder / "claims.json").read_text())["claims"]
    assert all(escape(claim["figure"]) in page for claim in claims)
    assert page.count("✓ pass") == len(claims)
    assert page.count("data:image/svg+xml;base64,") == 1 + 2 * 3
    assert page.count("data:image/png;base64,") == 1
    assert 'src="certified-omni/scene.mp4"' in page
    assert "tandem run carry &lt;here&gt;" in page


def test_the_page_says_which_speed_was_used_and_what_it_allows(folder: Path) -> None:
    page = (folder / "index.html").read_text()
    assert "certified-omni: hands at up to 0.1" in page
    assert re.search(r"Of the excess that they account for, \d+ % was found at most", page)
    assert "paper-omni: hands at up to" not in page


def test_tables_compare_the_runs_axis_by_axis_and_movement_by_movement(folder: Path, carried: Recording) -> None:
    page = (folder / "index.html").read_text()
    found = measure(carried)
    compared, limits, movements = json.loads((folder / "claims.json").read_text())["tables"]
    for table in (compared, limits, movements):
        assert f"<h3>{table['title']}</h3>" in page
        assert all(len(row) == len(table["head"]) for row in table["rows"])
        for row in table["rows"]:
            for name, cell in zip(table["head"][1:], row[1:], strict=True):
                # The name stands before each figure where the page is narrow.
                assert f'<td data-name="{escape(name)}">{escape(cell)}</td>' in page
    assert compared["head"][1:] == ["certified-omni", "paper-omni"]
    figures = {name: figure for name, figure, _ in compared["rows"]}
    assert figures["largest"] == f"{max(found.excess.peaks):.2f} limits"
    assert figures["hands' torque"] == f"{found.effort.torque:.1f} Nm"
    over, largest = limits["rows"][:2]
    assert over[2:] == [f"{100 * share:.1f} %" for share in found.excess.over_each]
    assert largest[2:] == [f"{peak:.2f} x" for peak in found.excess.peaks]
    assert max(found.excess.over_each) <= found.excess.over <= sum(found.excess.over_each)
    ours = [row for row in movements["rows"] if row[0] == "certified-omni"]
    assert [row[1] for row in ours] == [one.name for one in found.followed]
    assert ours[0][1:4] == ["pull", "0.50 m", "100 %"] and ours[-1][2] == "90°" and ours[-1][5] == "–"


def test_a_carry_that_did_not_get_there_has_its_row_all_the_same(carried: Recording) -> None:
    recording = copy.deepcopy(carried)
    defects.stuck(recording)
    recording.topics["sim/world"]["hand.doing"][:] = "wait"
    compared, _, movements = tables({"certified-omni": measure(recording)})
    assert compared.rows[0][1] == "not (carrying)" and compared.rows[-1][1] == "–"
    assert movements.rows[-1][2:] == ("90°", "0 %", "0 %", "–", "–", "–", "–")


def test_every_figure_is_there_in_both_formats(folder: Path) -> None:
    kinds = ("wrench", "paths", "heights")
    names = {"comparison", *(f"{name}-{kind}" for name in ("certified-omni", "paper-omni") for kind in kinds)}
    for suffix in (".svg", ".png"):
        assert {path.stem for path in (folder / "figures").glob(f"*{suffix}")} == names


def test_a_carry_that_was_dropped_fails_the_command_and_is_drawn_all_the_same(
    carried: Recording, tmp_path: Path
) -> None:
    dropped = copy.deepcopy(carried)
    defects.lost(dropped)
    assert write(CARRY, {"certified-omni": dropped}, tmp_path).status == 1
    assert "✗ fail" in (tmp_path / "index.html").read_text()


def test_a_panel_that_was_never_let_go_can_be_drawn(carried: Recording) -> None:
    held = copy.deepcopy(carried)
    defects.never_let_go(held)
    found = measure(held)
    frame = Frame.of({"certified-omni": held}, {"certified-omni": found})
    for draw in (figures.draw_wrench, figures.draw_paths, figures.draw_heights):
        assert draw(CARRY.run_named("certified-omni"), held, found, frame).axes


def test_figures_of_different_runs_have_the_same_scales(carried: Recording) -> None:
    hard = copy.deepcopy(carried)
    hard.topics["wrench/external"]["force"][:, 1] *= 2.0
    runs = {"certified-omni": carried, "paper-omni": hard}
    measured = {name: measure(recording) for name, recording in runs.items()}
    frame = Frame.of(runs, measured)
    for draw in (figures.draw_wrench, figures.draw_paths, figures.draw_heights):
        drawn = [draw(CARRY.run_named(name), runs[name], measured[name], frame) for name in runs]
        scales = [[(*axes.get_xlim(), *axes.get_ylim()) for axes in figure.axes] for figure in drawn]
        assert scales[0] == scales[1]


def test_the_parts_are_those_of_the_script_in_its_order(carried: Recording) -> None:
    names = [part.name for part in recorded_parts(carried) if part.name]
    assert names == [
        *("grasp", "lift", "pull", "push", "left", "right", "twist", "twist back", "turn", "lower"),
        *("release", "let go"),
    ]


def test_an_empty_folder_is_refused_with_one_line(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="no recording of any run"):
        report(tmp_path)


def test_the_stills_tell_the_whole_carry(carried: Recording) -> None:
    found = recorded_parts(carried)
    told = ["marker found", "grasped", "lifted", "pulled", "led sideways", "twisted", "turned upright", "set down"]
    assert [part.still for part in sorted(found, key=lambda part: part.end) if part.still] == told
    assert all(part.start < part.end for part in found)


def test_no_state_of_the_task_goes_without_words() -> None:
    from services.task.states import State

    assert set(STATES) == {state.value for state in State}
