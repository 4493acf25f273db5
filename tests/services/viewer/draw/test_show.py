"""Every topic is drawn where it belongs, at its time, and taken away when it is old."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from services.viewer.draw.colours import AMBER, GREEN, RED
from services.viewer.draw.robot import Robot
from services.viewer.draw.show import table
from services.viewer.draw.tool import PER_NEWTON
from services.viewer.heard import WATCHED
from shared import topics as t
from shared.processes import HEALTHY
from shared.robot.tiago import URDF
from shared.topics import Topic, health_topic
from tests.services.viewer.drawn import Stage
from tests.services.viewer.known import control, health, task
from tests.services.viewer.messages import MESSAGES, NOMINAL, TOOL, camera, joints, world, wrench

NOT_DRAWN = {t.SENSOR_FT, t.STATE_GRIPPER, t.STOP, t.OPERATOR_ENABLE, t.BASE_ENABLE}
NOT_DRAWN |= {t.COMMAND_BASE_TWIST, t.COMMAND_GRIPPER, t.COMMAND_HEAD}
"""Of these only the rate is shown, and what others make of them."""
ENTITIES: dict[str, set[str]] = {
    "sensor/camera": {"world/base/camera", "world/base/camera/picture"},
    "state/joints": {"tf/joints"},
    "state/ee": {"world/base/tool", "world/base/axes", "curves/speed/measured", "curves/turn/measured"},
    "state/base": {"world/base", "curves/base/measured"},
    "state/robot": {"phases/robot", "curves/speed/largest", "curves/turn/largest"},
    "command/ee_twist": {"curves/speed/commanded", "curves/turn/commanded"},
    "wrench/external": {
        "world/base/tool/wrench/force",
        "world/base/tool/wrench/torque",
        *(f"curves/wrench/{axis}" for axis in ("fx", "fy", "fz", "tx", "ty", "tz")),
    },
    "control/target": {"world/base/target", "world/base/target/hand"},
    "control/status": {
        "world/base/tool/limits",
        "world/base/tool/active/faces",
        "world/base/tool/active/names",
        "phases/control",
        "curves/used",
        "curves/margin/force",
        "curves/margin/torque",
        "curves/certificate/lyapunov",
        "curves/certificate/relaxation",
        "curves/solve",
        *(f"curves/limit/{axis}" for axis in ("fx", "fy", "fz", "tx", "ty", "tz")),
    },
    "base/status": {"phases/base", "curves/base/commanded"},
    "task/status": {"phases/task", "world/base/marker", "world/base/marker/name"},
    "sim/world": {
        "world/panel",
        "world/panel/body",
        "world/hands/hands",
        "world/hands/person",
        "world/hands/force",
        "world/hands/wanted",
        "world/hands/way",
        "world/base/bag",
        "phases/person",
    },
    "health/wrench": {"health/wrench", "curves/loop/wrench"},
}
"""By key, what its messages draw; a bag needs the tool that it hangs from."""
ALWAYS = {"/why/now", "/why/history", "/traffic/rate", "/traffic/delay"}


@pytest.fixture
def stage(tmp_path: Path) -> Stage:
    return Stage(tmp_path / "drawn.rrd")


def test_nothing_that_a_viewer_may_read_is_forgotten() -> None:
    drawn = set(table(Robot(rr.RecordingStream("test"))))
    assert drawn | {topic.key for topic in NOT_DRAWN} == {topic.key for topic in WATCHED}
    assert {topic.key for topic in MESSAGES} | {health_topic(name).key for name in HEALTHY} == drawn


@pytest.mark.parametrize("topic", MESSAGES, ids=lambda topic: topic.key)
def test_a_message_is_drawn_there_and_nowhere_else(stage: Stage, topic: Topic) -> None:
    stage.run(0.3, (topic, MESSAGES[topic]))
    wanted = {f"/{path}" for path in ENTITIES[topic.key]}
    assert stage.end().entities - ALWAYS == wanted


def test_all_together_the_bag_hangs_from_the_tool(stage: Stage) -> None:
    stage.run(0.3, *MESSAGES.items())
    rope = stage.end().last("world/base/bag/rope", "LineStrips3D:strips")[0]
    assert rope[0] == pytest.approx(TOOL) and rope[1] == pytest.approx((*TOOL[:2], 0.4))


def test_the_limits_stand_around_the_nominal_wrench_and_the_active_face_is_named(stage: Stage) -> None:
    stage.run(0.3, (t.CONTROL_STATUS, MESSAGES[t.CONTROL_STATUS]))
    drawn = stage.end()
    centre = PER_NEWTON * NOMINAL[:3]
    assert drawn.last("world/base/tool/limits", "Boxes3D:centers")[0] == pytest.approx(centre)
    assert drawn.last("world/base/tool/limits", "Boxes3D:half_sizes")[0] == pytest.approx((0.15, 0.15, 0.375))
    face = drawn.last("world/base/tool/active/faces", "Boxes3D:centers")[0]
    assert face == pytest.approx((0.0, 0.0, centre[2] - 0.375))
    assert drawn.last("world/base/tool/active/names", "Points3D:labels") == ["z force: 24.8 of 25 N"]
    # An arrow at the limit ends at its face.
    assert PER_NEWTON * (NOMINAL[2] - 25.0) == pytest.approx(face[2])


def test_the_box_is_green_near_a_limit_amber_and_red_at_it(stage: Stage) -> None:
    near = MESSAGES[t.CONTROL_STATUS].margin.copy()
    near[2] = 6.0
    wanted = [(control(), GREEN), (control(margin=near), AMBER), (MESSAGES[t.CONTROL_STATUS], RED)]
    for status, _ in wanted:
        stage.run(0.1, (t.CONTROL_STATUS, status))
    colours = [colour for _, (colour,) in stage.end().of("world/base/tool/limits", "Boxes3D:colors")]
    packed = [red << 24 | green << 16 | blue << 8 | 255 for _, (red, green, blue) in wanted]
    assert list(dict.fromkeys(colours)) == packed


def test_limits_that_are_none_are_taken_away(stage: Stage) -> None:
    stage.run(0.2, (t.CONTROL_STATUS, MESSAGES[t.CONTROL_STATUS]))
    stage.run(0.2, (t.CONTROL_STATUS, control("waiting", limit=np.zeros(6), margin=np.zeros(6))))
    drawn = stage.end()
    assert drawn.gone("world/base/tool/limits") and drawn.gone("world/base/tool/active")
    assert all(np.isnan(drawn.last("curves/used", "Scalars:scalars")[:6]))


def test_every_message_is_a_point_of_its_curves_at_its_own_time(stage: Stage) -> None:
    for number in range(50):
        stage.run(0.01, (t.WRENCH_EXTERNAL, wrench(float(number), 0.5)))
    points = stage.end().of("curves/wrench/fz", "Scalars:scalars")
    assert [value for _, value in points] == [[n, n - 0.5, n + 0.5] for n in range(50)]
    assert [time for time, _ in points] == pytest.approx(np.arange(50) * 0.01)


def test_what_falls_silent_is_taken_away_and_comes_back(stage: Stage) -> None:
    stage.run(0.5, *MESSAGES.items())
    without = {topic: message for topic, message in MESSAGES.items() if topic is not t.WRENCH_EXTERNAL}
    stage.run(0.5, *without.items())
    stage.run(0.2, *MESSAGES.items())
    drawn = stage.end()
    cleared = [time for time, _ in drawn.of("world/base/tool/wrench", "Clear:is_recursive")]
    assert len(cleared) == 1 and 0.5 < cleared[0] < 0.8
    assert not drawn.gone("world/base/tool/wrench") and not drawn.gone("world/base/tool/limits")


def test_what_is_forgotten_is_told_of_when_it_is_heard_again_and_not_left_standing(stage: Stage) -> None:
    status = t.CONTROL_STATUS, MESSAGES[t.CONTROL_STATUS]
    stage.run(0.5, *MESSAGES.items())
    stage.say(*status)
    stage.ears.forget(t.CONTROL_STATUS.key)
    assert t.CONTROL_STATUS.key not in stage.ears.known() and not stage.ears.take(t.CONTROL_STATUS.key)
    stage.run(2.0)
    assert t.CONTROL_STATUS.key not in stage.ears.known()
    stage.say(*status)
    assert stage.ears.known()[t.CONTROL_STATUS.key].age == 0.0
    drawn = stage.end()
    assert ["silent"] in [word for _, word in drawn.of("phases/control", "StateChange:state")]


def test_all_that_is_silent_is_gone_but_the_robot_s_shape(stage: Stage) -> None:
    stage.run(0.5, *MESSAGES.items())
    stage.run(3.0)
    drawn = stage.end()
    for path in ("tool/wrench", "tool/limits", "target", "camera", "marker", "bag"):
        assert drawn.gone(f"world/base/{path}"), path
    assert drawn.gone("world/panel") and drawn.gone("world/hands") and drawn.gone("curves/used")
    assert drawn.last("phases/control", "StateChange:state") == ["silent"]
    assert "no answer from" in drawn.last("why/now", "TextDocument:text")[0]


def test_what_leaves_the_scene_is_taken_away(stage: Stage) -> None:
    stage.run(0.2, *MESSAGES.items())
    stage.run(0.2, (t.STATE_EE, MESSAGES[t.STATE_EE]), (t.SIM_WORLD, world(False, False, False)))
    drawn = stage.end()
    assert drawn.gone("world/panel") and drawn.gone("world/hands") and drawn.gone("world/base/bag")


def test_a_state_is_told_on_change_and_again_for_whoever_comes_later(stage: Stage) -> None:
    stage.run(7.0, (t.TASK_STATUS, task("carrying")))
    stage.run(0.3, (t.TASK_STATUS, task("holding")))
    told = stage.end().of("phases/task", "StateChange:state")
    assert [word for _, (word,) in told] == ["carrying", "carrying", "holding"]
    assert told[1][0] - told[0][0] == pytest.approx(5.0, abs=0.2)


def test_a_service_that_falls_silent_is_in_no_good_health(stage: Stage) -> None:
    stage.run(1.0, (health_topic("base"), health()))
    stage.run(2.0)
    assert stage.end().last("health/base", "StateChange:state") == ["silent"]


@pytest.mark.parametrize(("encoding", "channels"), [("rgb8", 3), ("bgr8", 3), ("mono8", 1)])
def test_a_picture_without_compression_is_drawn_unless_it_is_too_short(
    stage: Stage, encoding: str, channels: int
) -> None:
    stage.run(0.1, (t.SENSOR_CAMERA, camera(encoding, bytes(range(8 * channels)))))
    stage.run(0.1, (t.SENSOR_CAMERA, camera(encoding, b"short", focus=0.0)))
    drawn = stage.end()
    assert [bytes(value[0]) for _, value in drawn.of("world/base/camera/picture", "Image:buffer")] == [
        bytes(range(8 * channels))
    ]
    assert len(drawn.of("world/base/camera/picture", "Pinhole:image_from_camera")) == 1


@pytest.mark.parametrize("moved", [{}, {"arm_right_3_joint": 0.7, "torso_lift_joint": 0.2, "head_1_joint": -0.4}])
def test_joints_move_as_rerun_s_own_reading_of_the_description_says(stage: Stage, moved: dict[str, float]) -> None:
    stage.run(0.2, (t.STATE_JOINTS, joints(**moved)))
    drawn = stage.end()
    tree = rr.urdf.UrdfTree.from_file_path(URDF)
    rows = {
        child[0]: (translation[0], quaternion[0])
        for (_, child), (_, translation), (_, quaternion) in zip(
            *(drawn.of("tf/joints", f"Transform3D:{part}") for part in ("child_frame", "translation", "quaternion")),
            strict=True,
        )
    }
    for joint in tree.joints():
        if joint.joint_type == "fixed":
            assert joint.child_link not in rows
            continue
        wanted = joint.compute_transform(moved.get(joint.name, 0.0))
        translation, quaternion = rows[joint.child_link]
        assert translation == pytest.approx(wanted.translation.as_arrow_array().to_pylist()[0], abs=1e-6)
        # A quaternion and its negative are the same turn.
        assert abs(np.dot(quaternion, wanted.quaternion.as_arrow_array().to_pylist()[0])) == pytest.approx(1.0)


def test_a_joint_that_rests_is_drawn_every_few_seconds_only(stage: Stage) -> None:
    stage.run(6.0, (t.STATE_JOINTS, joints()))
    stage.run(0.2, (t.STATE_JOINTS, joints(head_1_joint=0.1)))
    rows = stage.end().of("tf/joints", "Transform3D:child_frame")
    assert len(rows) == 2 * len(joints().name) + 1
