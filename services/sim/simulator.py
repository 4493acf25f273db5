"""The simulated robot as a service: the robot's side of the contract in front of the simulated world."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from services.sim.camera.head_camera import DirectRendering, HeadCamera, Rendering
from services.sim.camera.view import Scenery
from services.sim.pace import Pace, Ticks
from services.sim.parameters import SimParameters
from services.sim.robot.kinematics import CARRY_HOME, FULL_HOME, HOME
from services.sim.robot.sensor_line import SensorLine
from services.sim.robot.sensors import ForceTorqueSensor, JointSensors
from services.sim.scene.panel_scene import PanelScene
from services.sim.scene.world import World
from services.sim.sim_commands import Commands
from shared import topics
from shared.faults import Fault
from shared.messages import BaseState, FtSample, GripperState
from shared.requests import Nothing
from shared.robot import tiago
from shared.robot.gate import GateLimits
from shared.robot.side import RobotSide
from shared.schema.records import Record
from shared.service import Inputs, Output, Reply, Service, Wiring
from shared.sim_messages import Reset
from shared.spatial import quaternion
from shared.topics import Query

DOWN = np.array((0.0, 0.0, -1.0))
RENEWED = (*(topic for topic in topics.TOPICS if topic.key.startswith("state/")), topics.SENSOR_CAMERA)
"""Topics that begin a new session with a reset: the robot is elsewhere. The force sensor is the same, with its bias."""
_STARTS = {"full": FULL_HOME, "load": HOME, "carry": CARRY_HOME}


class Simulator(Service[SimParameters]):
    """Steps the world by one tick per call, executes what the gate lets through, and publishes what is due.

    A tick simulates the time since the last one. A command that arrived in between acts from the physics step on in
    which it arrived, and its time to live is counted from there: the gate's answers are as sharp as the physics steps.
    """

    def __init__(self, parameters: SimParameters, rendering: Callable[[Scenery], Rendering] = DirectRendering) -> None:
        super().__init__(parameters)
        self._ticks = Ticks(parameters.ft_rate, parameters.joint_rate, parameters.physics_rate)
        # Real time per simulated time: the gate's deadlines are promises in real time.
        self._stretch = 1.0 / parameters.real_time_factor
        scene = PanelScene(parameters.panel_scene(), self._ticks.step) if parameters.scene != "load" else None
        self.world = World(self._ticks.step, _STARTS[parameters.scene], scene, parameters.floor_slope)
        limits = GateLimits(
            parameters.max_linear,
            parameters.max_angular,
            parameters.max_linear_acceleration,
            parameters.max_angular_acceleration,
        )
        self.side = RobotSide(
            limits,
            parameters.base_type,
            simulated=True,
            base=tiago.BASES[parameters.base_type],
            gripper=tiago.GRIPPER_RANGES,
            head=tiago.HEAD_RANGES,
            require_enable=parameters.require_enable,
        )
        self._sensor = ForceTorqueSensor(parameters.ft_noise, parameters.ft_bias, parameters.ft_drift, parameters.seed)
        self._lines = {"ft": SensorLine(), "joints": SensorLine(), "camera": SensorLine()}
        self._camera = None
        if scene is not None:
            camera = self._lines["camera"]
            self._camera = HeadCamera(self.world, scene, parameters.scenery(), rendering, camera)
        world, joints = self.world, self._lines["joints"]
        self._joints = JointSensors(world.arm, world.head, world.gripper, world.start, joints)
        self._commands = Commands(self.world, self._lines)
        self._pace = Pace()
        self.wiring = Wiring(
            name="sim",
            driver=self._stretch / self._ticks.rate,
            optional=RobotSide.INPUTS,
            on_demand=() if self._camera is None else (topics.SENSOR_CAMERA,),
            queries=(topics.SIM_COMMAND,),
            # A late tick is no reason to stop the world: the gate watches over the commands' age.
            overrun_share=1.0,
        )

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """Simulate one tick; ``dt`` [s] of real time have passed since the last one."""
        self._pace.add(dt, self._stretch / self._ticks.rate)
        self._advance(inputs)
        return [*self._outputs(inputs.wanted(topics.SENSOR_CAMERA)), *self.side.report(dt, self.world.arm.limited_by)]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """The world stands still with the process."""
        return self.side.hold(fault.text)

    def query(self, query: Query, request: Record, reply: Reply) -> None:
        """Answer ``sim/command``."""
        self._commands.carry_out(request)
        if isinstance(request, Reset):
            self.side.hold("the scene was set back")
            self.renewed = RENEWED
        reply(Nothing())

    def notes(self) -> str:
        """Whether it keeps up, and the faults put on the sensors."""
        faults = (f"{name} sensor: {line.kind}" for name, line in self._lines.items() if line.kind != "ok")
        camera = self._camera.complaint if self._camera is not None else ""
        return "; ".join(note for note in (self._pace.complaint, camera, *faults) if note)

    def _advance(self, inputs: Inputs) -> None:
        step = self._ticks.step * self._stretch
        self.side.take(inputs, behind=self._ticks.substeps * step)
        if self.side.freeze:
            self.world.gripper.stay()
            self.world.head.stay()
        if (gripper := self.side.gripper) is not None:
            self.world.gripper.command(gripper.opening, gripper.effort)
        if (head := self.side.head) is not None:
            self.world.head.command(head.pan, head.tilt)
        for _ in range(self._ticks.substeps):
            twist, velocity = self.side.advance(step), self.side.advance_base(step)
            self.world.advance(twist, velocity, self.side.mode == "stopped")
        self._ticks.advance()

    def _outputs(self, watched: bool) -> list[Output]:
        tick = 1.0 / self._ticks.rate
        due = self._ticks.due
        ft = [Output(topics.SENSOR_FT, self._ft_sample())] if due(self.parameters.ft_rate) else []
        outputs = self._lines["ft"].send(ft, tick)
        joints = []
        if due(self.parameters.joint_rate):
            joint_state, tool = self._joints.measure()
            joints = [Output(topics.STATE_EE, tool), Output(topics.STATE_JOINTS, joint_state)]
        outputs += self._lines["joints"].send(joints, tick)
        if self._camera is not None:
            exposed = watched and due(self.parameters.camera_rate)
            outputs += self._camera.shots(exposed, self.world.time, tick, self._stretch)
        # Sensors keep their rates in simulated time, what is told of the rest its rate in real time.
        if due(topics.STATE_BASE.rate * self._stretch):
            outputs.append(Output(topics.STATE_BASE, self._base_state()))
        if due(topics.STATE_GRIPPER.rate * self._stretch):
            gripper = self.world.gripper
            state = GripperState(gripper.opening, gripper.effort, gripper.holding)
            outputs.append(Output(topics.STATE_GRIPPER, state))
        if due(topics.SIM_WORLD.rate * self._stretch):
            visible = self._camera is not None and self._camera.marker_visible()
            outputs.append(Output(topics.SIM_WORLD, self.world.told(visible)))
        return outputs

    def _ft_sample(self) -> FtSample:
        arm = self.world.arm
        line = self._lines["ft"]
        reading, saturated = line.stick(lambda: self._sensor.read(arm.physics.wrist_wrench(), self.world.time))
        reading = line.shift(reading)
        _, rotation = arm.kinematics.sensor()
        down = np.array(self.world.base.down) if self.parameters.tells_gravity else DOWN
        offset = arm.kinematics.tool_in_sensor
        return FtSample(reading[:3], reading[3:], quaternion(rotation), offset, saturated, down)

    def _base_state(self) -> BaseState:
        base = self.world.base
        return BaseState(np.array((base.x, base.y)), base.yaw, np.array(base.velocity))
