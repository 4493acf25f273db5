"""The layout: what explains the robot is seen without a click, and every view shows something that is drawn."""

from __future__ import annotations

from pathlib import Path

import pytest
from rerun.chunk import RrdReader

from services.viewer.blueprint import filmed, side_by_side
from services.viewer.stream import Stream
from tests.services.viewer.drawn import Drawn, Stage
from tests.services.viewer.messages import MESSAGES


def views(path: Path) -> dict[str, list[str]]:
    """Name and contents of the views in a file's layout."""
    reader = RrdReader(path)
    (stored,) = reader.blueprints()
    names: dict[str, str] = {}
    contents: dict[str, list[str]] = {}
    for chunk in reader.stream(store=stored).to_chunks():
        batch = chunk.to_record_batch()
        _, kind, *rest = chunk.entity_path.split("/")
        if kind == "view" and "ViewBlueprint:display_name" in batch.schema.names:
            names[rest[0]] = batch.column("ViewBlueprint:display_name").to_pylist()[-1][0]
            origin = batch.column("ViewBlueprint:space_origin").to_pylist()[-1][0]
            contents.setdefault(rest[0], []).insert(0, origin)
        if kind == "view" and "ViewContents:query" in batch.schema.names:
            contents.setdefault(rest[0], []).extend(batch.column("ViewContents:query").to_pylist()[-1])
    return {names[key]: value for key, value in contents.items()}


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Drawn]:
    path = tmp_path_factory.mktemp("view") / "drawn.rrd"
    stage = Stage(path)
    stage.run(1.5, *MESSAGES.items())
    return path, stage.end()


def test_every_view_shows_something_that_is_drawn(drawn: tuple[Path, Drawn]) -> None:
    path, content = drawn
    shown = views(path)
    assert len(shown) == 25
    for name, (origin, *queries) in shown.items():
        wanted = [query.replace("$origin", f"/{origin.strip('/')}") for query in queries if not query.startswith("-")]
        for query in wanted:
            prefix = query.removesuffix("/**")
            assert any(entity == prefix or entity.startswith(f"{prefix}/") for entity in content.rows), (name, query)


def test_every_curve_is_in_some_view(drawn: tuple[Path, Drawn]) -> None:
    path, content = drawn
    queries = [query.removesuffix("/**") for _, *some in views(path).values() for query in some]
    for entity in content.entities:
        if entity.startswith(("/curves", "/traffic")):
            assert any(entity == query or entity.startswith(f"{query}/") for query in queries), entity


def test_beside_each_other_each_recording_has_its_name_and_the_same_views(tmp_path: Path) -> None:
    path = tmp_path / "drawn.rrd"
    with Stream.written(path, side_by_side(["then", "with 15 N"])):
        pass
    shown = views(path)
    assert shown["then"] == ["/why/now", "$origin/**"] and shown["with 15 N"] == ["/beside/why/now", "$origin/**"]
    assert len(shown) == 2 + 4


@pytest.mark.parametrize("camera", [False, True])
def test_a_film_has_words_scene_and_limits_and_what_the_camera_sees_if_it_is_on(tmp_path: Path, camera: bool) -> None:
    path = tmp_path / "film.rrd"
    with Stream.written(path, filmed("film/words", camera)):
        pass
    shown = views(path)
    assert shown["words"][0].strip("/") == "film/words" and ("head camera" in shown) == camera
    assert len(shown) == 3 + camera
