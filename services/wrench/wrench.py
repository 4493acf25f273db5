"""The wrench service: one `wrench/external` per `sensor/ft` sample, and the queries that measure what to subtract."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from services.wrench.compensation import Compensation, transport
from services.wrench.error_bound import error_bound
from services.wrench.identification import IdentifiedPayload
from services.wrench.measurements import Measurements, described
from services.wrench.parameters import WrenchParameters
from services.wrench.sensor_watch import INVALID, SILENT, SensorWatch
from services.wrench.storage import Journal, load_payload, save_payload
from shared import topics
from shared.faults import Fault, FaultKind
from shared.messages import ExternalWrench
from shared.parameters import Refused
from shared.requests import AddPose, Poses, SolveIdentification, StartIdentification, Tare
from shared.schema.records import Record
from shared.service import Inputs, Output, Reply, Service, Wiring
from shared.spatial import Array, rotation_matrix


class Wrench(Service[WrenchParameters]):
    """Compensates, transports and judges each sample of the force-torque sensor.

    Args:
        parameters: checked parameters.
        folder: where the journal and a payload without a name are kept; None keeps nothing.

    Raises:
        Refused: if the payload file cannot be used.
    """

    wiring = Wiring(
        name="wrench",
        driver=topics.SENSOR_FT,
        required=(topics.SENSOR_FT,),
        queries=(topics.WRENCH_TARE, topics.WRENCH_IDENTIFY),
        parameters=topics.WRENCH_PARAMETERS,
        # It commands nothing: whoever uses its output waits for that to be healthy long enough.
        startup=0.0,
    )

    def __init__(self, parameters: WrenchParameters, folder: Path | None = None) -> None:
        super().__init__(parameters)
        self._configured(parameters, reload=True)
        self._folder = folder
        self._journal = Journal(folder / "wrench.json" if folder else None)
        self._watch = SensorWatch()
        self._lowpass = LowPass()
        self._measurements = Measurements(self._adopt)
        self._trouble = f"no {topics.SENSOR_FT.key} has come in yet"
        self._session: int | None = None
        self._last: ExternalWrench | None = None

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """The external wrench of the newest sample; ``valid`` is false while the sensor shows a fault."""
        reading = inputs[topics.SENSOR_FT]
        sample = reading.message
        if reading.header.session != self._session:
            self._follow(reading.header.session)
        settings = self.parameters
        raw = np.concatenate((sample.force, sample.torque))
        rotation = rotation_matrix(sample.orientation)
        fault = self._watch.update(
            raw,
            sample.saturated,
            dt,
            settings.stuck_after,
            settings.resolution,
            settings.sensor_range,
            self.compensation.weight(rotation),
        )
        to_tool = transport(rotation, sample.tool_offset)
        wrench = to_tool.dot(raw - self.compensation.offset(rotation))
        wrench = self._lowpass.filter(wrench, settings.lowpass_hz, dt)
        bound = error_bound(
            self.compensation,
            rotation,
            to_tool,
            self._noise_bound,
            self._bias_bound,
            settings.tool_mass,
            settings.tool_reach,
        )
        self._last = ExternalWrench(wrench[:3], wrench[3:], bound, self.compensation.kind, fault)
        self._trouble = f"the sensor is {fault}: {self._watch.reason}" if fault else ""
        if fault:
            self._measurements.abort(self._trouble)
        else:
            self._measurements.add(raw, rotation, dt, self.compensation)
        return [Output(topics.WRENCH_EXTERNAL, self._last, valid=not fault)]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """The last values, marked invalid; nothing before the first sample, since there is no value to give."""
        self._trouble = fault.text
        self._measurements.abort(fault.text)
        self._lowpass.reset()
        if self._last is None:
            return []
        word = SILENT if fault.kind is FaultKind.SILENT else INVALID
        return [Output(topics.WRENCH_EXTERNAL, self._last.replaced(fault=word), valid=False)]

    def query(self, query: topics.Query, request: Record, reply: Reply) -> None:
        """Answer a tare or a step of an identification; what needs an average is answered in a later step."""
        if isinstance(request, SolveIdentification):
            result = self._measurements.solve()
            self._adopt(result.compensation())
            reply(described(result, self._saved(result)))
        elif isinstance(request, (Tare, AddPose)):
            if self._trouble:
                raise Refused(self._trouble)
            self._measurements.begin(request, self._noise_bound, reply)
        else:
            self._measurements.restart(start=isinstance(request, StartIdentification))
            reply(Poses(0))

    def apply(self, parameters: WrenchParameters) -> None:
        """Take over parameters; another payload file is read at once.

        Raises:
            Refused: if that file cannot be used; nothing is changed then.
        """
        another = parameters.payload != self.parameters.payload
        self._configured(parameters, reload=another)
        self.parameters = parameters
        if another:
            self._adopt(self.compensation)

    def notes(self) -> str:
        """What a person should know of sensor, zero and files although the service works."""
        return "; ".join(filter(None, (self._trouble, self._watch.notes(), self._journal.problem)))

    def _configured(self, parameters: WrenchParameters, reload: bool) -> None:
        if reload:
            path = parameters.payload
            self.compensation = load_payload(Path(path)).compensation() if path else Compensation()
        self._noise_bound: Array = np.array(parameters.noise_bound)
        self._bias_bound: Array = np.array(parameters.bias_bound)
        self.max_delay = parameters.max_delay

    def _follow(self, session: int) -> None:
        """Another run of the robot process: what the journal has for it is taken up, else what is in force is kept."""
        recalled = self._journal.recall(session, self.parameters.payload) if self._session is None else None
        self._session = session
        self._watch = SensorWatch()
        if recalled is not None:
            self.compensation = recalled
        elif self.compensation.kind != "none":
            self._journal.record(session, self.parameters.payload, self.compensation)

    def _adopt(self, compensation: Compensation) -> None:
        self.compensation = compensation
        self._lowpass.reset()
        if self._session is not None:
            self._journal.record(self._session, self.parameters.payload, compensation)

    def _saved(self, result: IdentifiedPayload) -> str:
        """Where the result was written, empty if it could not be: it is in force all the same."""
        path = self.parameters.payload or (self._folder and self._folder / "payload.toml")
        if not path:
            return ""
        try:
            save_payload(Path(path), result)
        except Refused as problem:
            self._journal.problem = str(problem)
            return ""
        return str(path)


class LowPass:
    """First-order low pass of the external wrench, exact for an input held over each step.

    It delays what the controller sees: a ramp comes out 1 / (2 pi f) [s] late, which has to be counted in the
    controller's `delay`. It is not credited in the error bound.
    """

    def __init__(self) -> None:
        self._state: Array | None = None

    def filter(self, value: Array, cutoff: float, dt: float) -> Array:
        """The filtered value (6,); the first one after a start or a reset passes unchanged.

        Args:
            value: newest input (6,).
            cutoff: corner frequency [Hz], 0 = off.
            dt: time [s] since the last call.
        """
        if self._state is None or cutoff <= 0.0:
            self._state = value
        else:
            self._state = self._state + (1.0 - math.exp(-2.0 * math.pi * cutoff * dt)) * (value - self._state)
        return self._state

    def reset(self) -> None:
        """Forget the past, after a gap or a change of the compensation."""
        self._state = None
