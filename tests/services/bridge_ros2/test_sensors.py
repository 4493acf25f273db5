"""The newest message of each topic, and what several publishers say of the emergency stop."""

from __future__ import annotations

from services.bridge_ros2.sensors import Arrived, EmergencyStop, Newest
from shared.robot import ros_messages as ros
from tests.services.bridge_ros2 import peer

BOOL = "std_msgs/msg/Bool"


def wrench(force: float, kind: str = "") -> Arrived:
    still = peer.Vector3(0.0, 0.0, 0.0)
    told = peer.WrenchStamped(peer.Header(peer.Time(2, 5), "wrist"), peer.Wrench(peer.Vector3(force, 0.0, 0.0), still))
    return Arrived(told.serialize(), kind, "gid")


def test_the_newest_one_counts_and_is_numbered() -> None:
    newest = Newest("geometry_msgs/msg/WrenchStamped", ros.wrench)
    assert newest.heard is None
    newest.offer(wrench(1.0))
    newest.offer(wrench(2.0))
    heard = newest.heard
    assert heard is not None and heard is newest.heard
    assert (heard.message.force[0], heard.number, heard.stamp, heard.sender) == (2.0, 2, 2_000_000_005, "gid")
    newest.forget()
    assert newest.heard is None


def test_what_cannot_be_read_is_counted_and_the_one_before_stays() -> None:
    newest = Newest("geometry_msgs/msg/WrenchStamped", ros.wrench)
    newest.offer(wrench(1.0))
    assert newest.heard is not None and newest.refusals == ""
    for wrong in (Arrived(b"nonsense", "", ""), wrench(float("nan")), wrench(3.0, "geometry_msgs/msg/Wrench")):
        newest.offer(wrong)
        assert newest.heard is not None and newest.heard.number == 1
    assert newest.refusals == (
        "3 refused, the last one: it is geometry_msgs/msg/Wrench, the profile says geometry_msgs/msg/WrenchStamped"
    )


def say(stop: EmergencyStop, pressed: bool, sender: str = "") -> None:
    stop.offer(Arrived(peer.Bool(pressed).serialize(), BOOL, sender))


def test_of_several_publishers_none_overrules_another() -> None:
    stop = EmergencyStop(BOOL, pressed=True)
    stop.present(2)
    assert not stop.told() and stop.pressed_by() == ""
    say(stop, True, "aaaa")
    say(stop, False, "bbbb")
    assert stop.told() and stop.pressed_by() == "aaaa"
    say(stop, False, "aaaa")
    assert stop.pressed_by() == ""


def test_a_publisher_that_comes_again_takes_back_what_it_said() -> None:
    stop = EmergencyStop(BOOL, pressed=True)
    stop.present(1)
    say(stop, True, "before")
    stop.present(0)
    assert stop.pressed_by() == "before"
    stop.present(1)
    assert stop.pressed_by() == "before"
    say(stop, False, "after")
    assert stop.pressed_by() == ""


def test_a_publisher_that_is_gone_is_believed_until_all_others_have_spoken() -> None:
    stop = EmergencyStop(BOOL, pressed=True)
    stop.present(3)
    for sender in ("a", "b", "c"):
        say(stop, sender == "b", sender)
    stop.present(2)
    say(stop, False, "a")
    assert stop.pressed_by() == "b"
    say(stop, False, "c")
    assert stop.pressed_by() == ""


def test_a_value_of_false_may_mean_pressed() -> None:
    stop = EmergencyStop(BOOL, pressed=False)
    say(stop, False)
    assert stop.pressed_by() == "the robot"
    stop.offer(Arrived(b"", BOOL, ""))
    assert stop.pressed_by() == "the robot" and "1 refused" in stop.refusals
