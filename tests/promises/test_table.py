"""Nobody is forgotten: each process of the table has an entry here, and each input a second publisher."""

from __future__ import annotations

import pytest

from shared.processes import PROCESSES
from shared.topics import ANYBODY
from tests.promises.subjects import BY_NAME, SUBJECTS, Subject
from tests.promises.test_words import NONSENSE
from tests.promises.worlds import STRANGE


@pytest.mark.parametrize("name", [process.name for process in PROCESSES])
def test_every_process_has_an_entry(name: str) -> None:
    assert name in BY_NAME, f"{name} keeps no promise that anybody tests: add it to tests/promises/subjects.py"


def test_there_is_no_other_and_none_twice() -> None:
    assert [subject.name for subject in SUBJECTS] == [process.name for process in PROCESSES]


@pytest.mark.parametrize("subject", SUBJECTS, ids=repr)
def test_its_inputs_outputs_and_settings_are_tested(subject: Subject) -> None:
    assert (subject.output is not None) == subject.process.service
    assert set(STRANGE) >= {topic for topic in subject.inputs if ANYBODY not in topic.publishers}
    assert set(NONSENSE) >= set(subject.queries)
