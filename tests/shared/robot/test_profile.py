"""Robots' profiles: those that are shipped load, and whatever is wrong with one is said in one line."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shared.parameters import Refused
from shared.robot.profile import PROFILES, Profile

SHIPPED = ("tiago-ros1", "tiago-ros2", "ur5e-ros2")
TIAGO = tomllib.loads((PROFILES / "tiago-ros1.toml").read_text(encoding="utf-8"))
HERE = Path("/robots/mine.toml")


def changed(*path: Any, to: Any = None) -> dict[str, Any]:
    """The TIAGo's profile with one entry replaced, or taken away."""
    content = copy.deepcopy(TIAGO)
    table: Any = content
    for step in path[:-1]:
        table = table[step]
    if to is None:
        del table[path[-1]]
    else:
        table[path[-1]] = to
    return content


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_profile_loads_by_its_name_and_by_its_path(name: str) -> None:
    by_name = Profile.load(name)
    assert by_name.name == name
    assert by_name == Profile.load(str(PROFILES / f"{name}.toml"))


def test_the_shipped_profiles_are_known_here() -> None:
    assert sorted(path.stem for path in PROFILES.glob("*.toml")) == list(SHIPPED)


def test_types_are_written_as_the_middleware_writes_them() -> None:
    first, second = Profile.load("tiago-ros1"), Profile.load("tiago-ros2")
    assert first.heard()["/joint_states"] == "sensor_msgs/JointState"
    assert second.heard()["/joint_states"] == "sensor_msgs/msg/JointState"
    assert first.commanded()["/arm_right_controller/command"] == "trajectory_msgs/JointTrajectory"
    assert second.commanded()["/servoing_cmd_vel"] == "geometry_msgs/msg/Twist"


def test_each_joint_of_the_arm_is_commanded_at_its_place() -> None:
    profile = Profile.load("tiago-ros1")
    assert profile.arm_controllers() == {"torso": (0,), "arm": (1, 2, 3, 4, 5, 6, 7)}


def test_ranges_are_those_of_the_robot_and_of_nothing_where_it_has_none() -> None:
    tiago, arm = Profile.load("tiago-ros2"), Profile.load("ur5e-ros2")
    assert tiago.gripper_ranges() == {"opening": (0.0, 0.09), "effort": (0.0, 16.0)}
    assert tiago.head_ranges() == {"pan": (-1.309, 1.309), "tilt": (-1.047, 0.785)}
    assert set((*arm.gripper_ranges().values(), *arm.head_ranges().values())) == {(0.0, 0.0)}


def test_readings_are_turned_into_the_sensor_frame_with_their_sign() -> None:
    content = changed("wrench", "rotation", to=[0.0, 0.0, np.pi / 2])
    content["wrench"]["sign"] = -1
    axes = Profile.of(content, HERE).wrench.axes
    assert axes @ (1.0, 0.0, 0.0) == pytest.approx((0.0, -1.0, 0.0))


ARM = TIAGO["arm"]["joints"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (changed("urdf"), "urdf is missing"),
        (changed("urdf", to="pr2.urdf"), "urdf is pr2.urdf: neither in /robots nor in"),
        (changed("middleware", to="yarp"), "middleware is yarp: "),
        (
            changed("middleware", to="ros2"),
            "[base] type is geometry_msgs/Twist, under ros2 wanted geometry_msgs/msg/Twist",
        ),
        (changed("speed", to=1), "speed is not known here"),
        (changed("name", to="x"), "name is not known here"),
        (changed("wrench", "ratte", to=1), "[wrench] ratte is not known here"),
        (changed("wrench", "topic"), "[wrench] topic is missing"),
        (changed("wrench"), "wrench, or a table of that name, is missing"),
        (changed("wrench", "rate", to=-5), "[wrench] rate is -5: input should be greater than 0"),
        (changed("wrench", "rate", to="fast"), "[wrench] rate is fast"),
        (changed("wrench", "sign", to=0), "[wrench] sign is 0"),
        (changed("joints", "topic", to="joint states"), "[joints] topic is joint states"),
        (changed("joints", "topic", to=TIAGO["wrench"]["topic"]), "topic /wrist_right_ft is named twice"),
        (changed("frames", "tool", to="hand"), "[frames] tool is hand, which tiago.urdf has not"),
        (changed("frames", "camera", to="eye"), "[frames] camera is eye, which tiago.urdf has not"),
        (changed("frames", "base", to="base_link"), "[frames] base is base_link, wanted base_footprint"),
        (changed("frames", "sensor", to="wrist_left_ft_link"), "which does not carry the tool"),
        (changed("frames", "sensor", to="arm_right_6_link"), "a joint moves the tool"),
        (changed("arm", "joints", to=["torso", *ARM[1:]]), "[arm] joint torso is none that moves in tiago.urdf"),
        (changed("arm", "joints", to=[ARM[1], ARM[0], *ARM[2:]]), "[arm] joints are arm_right_1_joint, torso_lift"),
        (changed("arm", "joints", to=ARM[:5]), "[arm] joints are 5, wanted 6 at least"),
        (changed("arm", "acceleration", to=[1.0]), "[arm] acceleration has 1 elements, wanted one for each of 8"),
        (changed("arm", "acceleration", to=[0.0] * 8), "[arm] acceleration has a 0"),
        (
            changed("arm", "home", to=[2.0] * 8),
            "[arm] home of torso_lift_joint is 2, in tiago.urdf it goes from 0 to 0.35",
        ),
        (changed("arm", "lift", "joint", to="head_1_joint"), "[arm.lift] joint is head_1_joint"),
        (changed("controllers", "torso"), "[controllers] none has torso_lift_joint"),
        (changed("controllers", "torso", "joints", to=["lift"]), "[controllers.torso] joint lift is none that moves"),
        (changed("controllers", "torso", "joints", to=ARM[:2]), "has more than one controller"),
        (changed("controllers", "head", "joints", to=["torso_lift_joint"]), "has more than one controller"),
        (changed("head", "controller", to="neck"), "[head] controller is neck, there are torso, arm, head, gripper"),
        (changed("gripper", "joints", to=TIAGO["head"]["joints"]), "[gripper] joints are not those of"),
        (changed("base_type", to="none"), 'base_type is "none", but there is a [base]'),
        (changed("base"), 'base_type is "differential", wanted a [base]'),
        (changed("base", "sideways", to=1.0), "a differential base goes 0 m/s sideways"),
        (changed("emergency_stop", "type", to="std_msgs/Int8"), "[emergency_stop] type is std_msgs/Int8"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_wrong_is_said_in_one_line(content: dict[str, Any], words: str) -> None:
    with pytest.raises(Refused) as refused:
        Profile.of(content, HERE)
    text = str(refused.value)
    assert text.startswith("robot profile /robots/mine.toml: ")
    assert words in text
    assert "\n" not in text


def test_switching_is_of_ros1_only(tmp_path: Path) -> None:
    text = (PROFILES / "tiago-ros2.toml").read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(text + '\n[switching]\nservice = "/switch"\n', encoding="utf-8")
    with pytest.raises(Refused, match=r"\[switching\] is of ros1"):
        Profile.load(str(path))


@pytest.mark.parametrize(
    ("which", "words"),
    [("tiago", "there are tiago-ros1, tiago-ros2, ur5e-ros2, or the path"), ("./none.toml", "No such file")],
)
def test_a_profile_that_is_not_there_is_refused_by_name(which: str, words: str) -> None:
    with pytest.raises(Refused, match=words):
        Profile.load(which)


def test_what_is_no_toml_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xff")
    with pytest.raises(Refused, match="not TOML"):
        Profile.load(str(path))


@pytest.mark.parametrize(
    ("urdf", "words"),
    [
        ("<robot", "not XML"),
        ("<robot/>", "0 links are carried by no joint"),
        ('<robot><link name="a"/><link name="b"/></robot>', "2 links are carried by no joint"),
        ("<robot><link/></robot>", "no valid URDF"),
    ],
)
def test_a_description_that_is_none_is_refused(tmp_path: Path, urdf: str, words: str) -> None:
    (tmp_path / "mine.urdf").write_text(urdf, encoding="utf-8")
    with pytest.raises(Refused, match=words):
        Profile.of(changed("urdf", to="mine.urdf"), tmp_path / "mine.toml")


leaves = st.none() | st.booleans() | st.integers(-3, 3) | st.floats() | st.text(max_size=8)
anything = st.recursive(leaves, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner))


def places(table: dict[str, Any], above: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found = []
    for key, value in table.items():
        found.append((*above, key))
        found += places(value, (*above, key)) if isinstance(value, dict) else []
    return found


def spoil(table: dict[str, Any], place: tuple[str, ...], edit: Callable[[dict[str, Any], str], object]) -> None:
    for step in place[:-1]:
        table = table[step]
    edit(table, place[-1])


@given(st.sampled_from(places(TIAGO)), anything)
def test_nothing_that_a_field_may_be_is_more_than_refused(place: tuple[str, ...], value: Any) -> None:
    content = copy.deepcopy(TIAGO)
    spoil(content, place, lambda table, key: table.update({key: value}))
    try:
        Profile.of(content, HERE)
    except Refused as refused:
        assert "\n" not in str(refused)
