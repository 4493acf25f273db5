"""Rigid-body dynamics of the torso and the right arm in PyBullet, motors and wrist reaction included."""

from __future__ import annotations

import tempfile
import weakref
from pathlib import Path

import numpy as np
import pybullet

from services.sim.robot.physics_model import physics_urdf
from shared.robot.tiago import CHAIN, SENSOR_JOINT
from shared.spatial import GRAVITY, Array

SOLVER_ITERATIONS = 15  # with as many the motors give way by 3e-5 m at the tool under 28 N
FRICTION = np.array([0.0] + [1.0] * (len(CHAIN) - 1))
"""[N, Nm] Friction of the gears: it helps to hold a joint still, and is not part of the motor's effort."""
SLIP_DAMPING = (0.0, 10.0, 10.0, 8.0, 8.0, 4.0, 2.0, 0.3)
"""[Nm s/rad] Resistance of the gears of a joint that is pushed away: it gives way slowly instead of collapsing. Towards
the hand it is as much as an explicit damper on so little inertia may have."""
SLIPPING = 2e-3  # [m/s, rad/s] between a joint's speed and its set-point's above which it counts as pushed away
POSITION_GAIN = 0.1  # [1] share of a position error that a motor removes per step: 20 ms at 500 Hz


class Physics:
    """The arm in its own physics world.

    Each joint has a motor that follows a set-point with feed-forward of its velocity and gives at most the joint's
    effort limit, as a real drive does; the friction of its gears helps it to hold still.

    What happens in every step is written in plain floats: on eight of them numpy takes longer to begin than to compute.

    Attributes:
        positions, velocities: of the chain's joints, 8 each [m, rad, m/s, rad/s], after the last step.

    Args:
        home: joint positions (8,) at the start.
        effort: effort limits (8,) [N, Nm].
        step: duration [s] of one step.
    """

    def __init__(self, home: Array, effort: Array, step: float) -> None:
        self.step_time = step
        self._home = home
        self._limit = effort
        self._moving_limit: list[float] = effort.tolist()
        self._holding_limit: list[float] = (effort + FRICTION).tolist()
        self._client = pybullet.connect(pybullet.DIRECT)
        # The engine's memory is not Python's: nobody gives it back for a simulation that is no more.
        self._release = weakref.finalize(self, pybullet.disconnect, self._client)
        self._on = {"physicsClientId": self._client}
        pybullet.setGravity(0, 0, -GRAVITY, **self._on)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step,
            numSolverIterations=SOLVER_ITERATIONS,
            # Without it, torques are about the centre of mass of the body behind the joint.
            jointFeedbackMode=pybullet.JOINT_FEEDBACK_IN_JOINT_FRAME,
            deterministicOverlappingPairs=1,
            **self._on,
        )
        self._gravity = (0.0, 0.0, -GRAVITY)
        self._body = self._load()
        names = [
            pybullet.getJointInfo(self._body, joint, **self._on)[1].decode()
            for joint in range(pybullet.getNumJoints(self._body, **self._on))
        ]
        self._joints = [names.index(name) for name in CHAIN]
        self._wrist = names.index(SENSOR_JOINT)
        for link in range(-1, len(names)):
            pybullet.changeDynamics(self._body, link, linearDamping=0, angularDamping=0, jointDamping=0, **self._on)
        pybullet.enableJointForceTorqueSensor(self._body, self._wrist, True, **self._on)
        # The reaction comes in the axes of the body's principal inertia, which are not those of the joint.
        principal = pybullet.getDynamicsInfo(self._body, self._wrist, **self._on)[4]
        rotation = np.array(pybullet.getMatrixFromQuaternion(principal)).reshape(3, 3)
        self._onto_sensor = -np.kron(np.eye(2), rotation)
        self._gains = [POSITION_GAIN] * len(CHAIN), [1.0] * len(CHAIN)
        self.reset()

    def _load(self) -> int:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(physics_urdf(), encoding="utf-8")
            return pybullet.loadURDF(
                str(path), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE, **self._on
            )

    def reset(self) -> None:
        """Back to the start configuration, at rest."""
        self.feel((0.0, 0.0, -GRAVITY))
        for joint, position in zip(self._joints, self._home.tolist(), strict=True):
            pybullet.resetJointState(self._body, joint, position, 0.0, **self._on)
        self.drive(self._home.tolist(), [0.0] * len(CHAIN))
        self._read()

    def drive(self, positions: list[float], velocities: list[float]) -> None:
        """Set-points, 8 each [m, rad, m/s, rad/s], that the motors hold until the next call."""
        self._target_velocities = velocities
        forces = [
            holding if velocity == 0.0 else moving
            for velocity, holding, moving in zip(velocities, self._holding_limit, self._moving_limit, strict=True)
        ]
        pybullet.setJointMotorControlArray(
            self._body,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=positions,
            targetVelocities=velocities,
            forces=forces,
            positionGains=self._gains[0],
            velocityGains=self._gains[1],
            **self._on,
        )

    def push(self, force: list[float], torque: list[float] | None, point: list[float]) -> None:
        """Let a force [N] at a point [m] and a torque [Nm], all in base axes, act on the gripper for one step."""
        pybullet.applyExternalForce(self._body, self._wrist, force, point, pybullet.WORLD_FRAME, **self._on)
        if torque is not None:
            pybullet.applyExternalTorque(self._body, self._wrist, torque, pybullet.WORLD_FRAME, **self._on)

    def feel(self, gravity: tuple[float, float, float]) -> None:
        """The acceleration [m/s2], base axes, that every body feels from now on: gravity, and the base's motion."""
        if gravity != self._gravity:
            self._gravity = gravity
            pybullet.setGravity(*gravity, **self._on)

    def step(self) -> None:
        """Let one step of time pass."""
        pybullet.stepSimulation(**self._on)
        self._read()
        slip = [velocity - target for velocity, target in zip(self.velocities, self._target_velocities, strict=True)]
        if max(slip) > SLIPPING or min(slip) < -SLIPPING:
            # Acts in the next step, in addition to the motors.
            pybullet.setJointMotorControlArray(
                self._body,
                self._joints,
                pybullet.TORQUE_CONTROL,
                forces=[-damping * speed for damping, speed in zip(SLIP_DAMPING, slip, strict=True)],
                **self._on,
            )

    def _read(self) -> None:
        states = pybullet.getJointStates(self._body, self._joints, **self._on)
        self.positions: tuple[float, ...]
        self.velocities: tuple[float, ...]
        self.positions, self.velocities, _, self._efforts = zip(*states, strict=True)

    @property
    def position(self) -> Array:
        """Positions (8,) [m, rad] of the chain's joints after the last step."""
        return np.array(self.positions)

    @property
    def velocity(self) -> Array:
        """Velocities (8,) [m/s, rad/s] of the chain's joints after the last step."""
        return np.array(self.velocities)

    def effort(self) -> Array:
        """Efforts (8,) [N, Nm] of the motors in the last step; what friction holds is not theirs."""
        return np.minimum(np.maximum(self._efforts, -self._limit), self._limit)

    def wrist_wrench(self) -> Array:
        """Wrench (6,) [N, Nm] that everything beyond the sensor exerts on it: about its origin, in its axes.

        Weight and inertia of the gripper are part of it, as in a real sensor.
        """
        reaction = pybullet.getJointState(self._body, self._wrist, **self._on)[2]
        wrench: Array = self._onto_sensor.dot(reaction)
        return wrench

    def close(self) -> None:
        """Release the physics world."""
        self._release()
