"""What a process says of its own certificate: nothing, that it ends soon, that it has ended, that it was replaced."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from shared.wire.certificate import Certificate
from shared.wire.credentials import Credentials
from shared.wire.renewal import Renewal
from tests.support.closed import make

DAY = 86400.0


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return make(tmp_path, "--only", "wrench") / "wrench"


def again(place: Path, *options: str) -> None:
    make(place.parent, "--renew", "--only", "wrench", *options)


@pytest.mark.parametrize(
    ("days", "left", "soon"),
    [(365.0, 15.0, False), (365.0, 13.9, True), (30.0, 3.1, False), (30.0, 2.9, True), (365.0, -1.0, True)],
)
def test_two_weeks_or_a_tenth_of_its_time_before_its_end_a_certificate_ends_soon(
    days: float, left: float, soon: bool
) -> None:
    certificate = Certificate("tiago.wrench", 0.0, days * DAY)
    now = (days - left) * DAY
    assert certificate.ends_soon(now) is soon
    assert certificate.expired(now) is (left < 0.0)


def test_a_remark_comes_with_the_end_and_goes_with_another_certificate(place: Path) -> None:
    assert Renewal(Credentials(place)).remark() == ""
    again(place, "--days", "0.003")
    renewal = Renewal(Credentials(place))
    end = Credentials(place).own().end
    ends = f"the certificate of tiago.wrench ends on {end}: make another one in {place} with `tandem keys`"
    assert renewal.remark() == ends
    again(place)
    # What has just been written is looked at when it rests.
    assert (renewal.renewed(), renewal.remark()) == (False, ends)
    assert (renewal.renewed(), renewal.remark()) == (True, "")


def test_what_cannot_be_used_is_not_taken_over(place: Path) -> None:
    renewal = Renewal(Credentials(place))
    shutil.copy(make(place.parent / "other", "--only", "wrench") / "wrench" / "key.pem", place / "key.pem")
    assert not renewal.renewed()
    assert not renewal.renewed()
    assert "cannot be used (key values mismatch)" in renewal.remark()
    again(place)
    assert not renewal.renewed()
    assert renewal.renewed()
    assert renewal.remark() == ""


def test_the_same_certificate_written_once_more_is_no_other_one(place: Path) -> None:
    renewal = Renewal(Credentials(place))
    shutil.copy(shutil.copy(place / "authority.pem", place / "copy"), place / "authority.pem")
    assert not any(renewal.renewed() for _ in range(3))
