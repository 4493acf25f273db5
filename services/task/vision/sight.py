"""What the camera shows of the marker, and whether to go by it: each image passes all that may be wrong with one."""

from __future__ import annotations

from services.task.faults import TaskFault
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.vision.detection import BadImage, Detector
from services.task.vision.liveness import Liveness
from services.task.vision.marker_tracker import MarkerTracker
from services.task.vision.proof import Proof
from shared.clock import seconds
from shared.messages import CameraImage
from shared.service import Reading


class Sight:
    """Detector, tracker and proofs together.

    Attributes:
        tracker: of the marker.
        proof: of the camera.
        liveness: of its pictures.
    """

    def __init__(self, parameters: TaskParameters) -> None:
        self._number = parameters.marker_id
        self._detector = Detector(parameters.marker_size)
        self.tracker = MarkerTracker(parameters)
        self.proof = Proof(parameters)
        self.liveness = Liveness()

    def reset(self) -> None:
        """Forget everything."""
        self.tracker.reset()
        self.proof.reset()
        self.liveness.reset()

    def advance(self, dt: float) -> None:
        """Let time [s] pass."""
        self.tracker.advance(dt)
        self.proof.advance(dt)

    @property
    def marker(self) -> Pose | None:
        """The marker in base, if it may be gone by."""
        return self.tracker.pose if self.proof.proven else None

    @property
    def nudge(self) -> float:
        """How far [rad] the head has to be turned aside now, so that a camera without noise shows that it lives."""
        return self.liveness.nudge if self.proof.proven else 0.0

    @property
    def doubt(self) -> TaskFault | None:
        """Why it may not; None if it may."""
        return self.tracker.doubt or self.proof.doubt

    def look(self, reading: Reading, tool: Reading) -> None:
        """Take in a new image; ``tool`` is the newest pose of the tool."""
        image: CameraImage = reading.message
        camera = Pose.of(image.position, image.orientation)
        if not reading.header.valid:
            return self.tracker.useless(TaskFault("camera_invalid"))
        try:
            found = self._detector.find(image, self.tracker.known(camera))
        except BadImage as problem:
            return self.tracker.useless(problem.fault)
        seen = any(candidate.number == self._number for candidate in found)
        hindrance = None if seen else self._detector.hindrance(self._number)
        # A picture that shows nothing stays the same whether its camera lives or not.
        stale = (
            self.liveness.look(image.data, camera) if hindrance is None or hindrance.name != "camera_blank" else None
        )
        # During the proof the head turns, which no frozen camera follows; later nothing else would tell.
        if stale is not None and (stale.name != "camera_repeats" or self.proof.proven):
            return self.tracker.useless(stale)
        self.tracker.look(found, camera, _age(reading, tool), hindrance)
        self.proof.look(image, reading.header.session, camera, self.tracker.seen, self.tracker.pose)


def _age(image: Reading, tool: Reading) -> float:
    """Time [s] since an image was taken.

    A reading's age is referred to the fastest message since the subscription began, so that a camera that lags all the
    time would show the past as the present. Where one process publishes image and pose their stamps are of one clock.
    """
    if image.header.session != tool.header.session:
        return image.age
    return max(image.age, tool.age + seconds(tool.header.stamp - image.header.stamp))
