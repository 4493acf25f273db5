"""The wrench service: one `wrench/external` per `sensor/ft` sample, and the queries that measure what to subtract."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from services.wrench.averaging import Average, AveragingWindow
from services.wrench.compensation import Compensation, transport, upright, weight_of_up
from services.wrench.error_bound import bias_error, error_bound
from services.wrench.identification import IdentifiedPayload
from services.wrench.lowpass import LowPass
from services.wrench.measurements import Measurements, described
from services.wrench.parameters import WrenchParameters
from services.wrench.plausibility import Declared, Former, forced, lightest, payload_doubt, refusal, tare_doubt
from services.wrench.sensor_watch import INVALID, SILENT, SensorWatch
from services.wrench.storage import JOURNAL, PAYLOAD, Journal, JournalEntry, load_payload, payload_text, save_payload
from services.wrench.zero import Zero
from shared import topics
from shared.faults import Fault, FaultKind
from shared.messages import ExternalWrench
from shared.parameters import Refused
from shared.requests import AddPose, Poses, SolveIdentification, StartIdentification, Tare, Tared
from shared.schema.records import Record
from shared.service import Inputs, Output, Reply, Service, Wiring
from shared.spatial import Array, rotation_matrix

ATTITUDE = 0.005  # [rad] that a robot's own kinematics may be wrong by, besides the floor
REFUTED = 1.5  # times a declared bound: what ten readings say of a noise is no better known


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
        self._journal = Journal(folder / JOURNAL if folder else None)
        self._watch = SensorWatch()
        self._lowpass = LowPass()
        self._measurements = Measurements(self._tared)
        self._tool_offset: Array = np.zeros(3)
        self._zero = Zero()
        self._period = 0.0
        self._tare_began = 0
        self._identification_began: int | None = None
        self._trouble = f"no {topics.SENSOR_FT.key} has come in yet"
        self._session: int | None = None
        self._last: ExternalWrench | None = None

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """The external wrench of the newest sample; ``valid`` is false while the sensor shows a fault."""
        reading = inputs[topics.SENSOR_FT]
        sample = reading.message
        settings = self.parameters
        if reading.header.session != self._session:
            self._follow(reading.header.session, reading.header.stamp, dt)
        self._zero.sampled(reading.header.stamp)
        self._period += 0.05 * (dt - self._period)
        raw = np.concatenate((sample.force, sample.torque))
        rotation = rotation_matrix(sample.orientation)
        standing = upright(rotation, sample.gravity)
        fault = self._watch.update(
            raw,
            sample.saturated,
            dt,
            settings.stuck_after,
            settings.resolution,
            settings.sensor_range,
            self._least_weight(standing, sample.tool_offset),
            known=self.compensation.kind == "payload",
        )
        self._tool_offset = sample.tool_offset
        to_tool = transport(rotation, sample.tool_offset)
        wrench = to_tool.dot(raw - self.compensation.offset(standing))
        wrench = self._lowpass.filter(wrench, settings.lowpass_hz, dt)
        bound = error_bound(
            self.compensation,
            rotation,
            to_tool,
            self._box(standing),
            (max(settings.tool_mass, self.compensation.tool_mass), settings.tool_reach),
            sample.gravity,
            settings.floor_tilt,
        )
        self._last = ExternalWrench(wrench[:3], wrench[3:], bound, self.compensation.kind, fault, self._zero.age)
        self._trouble = f"the sensor is {fault}: {self._watch.reason}" if fault else ""
        if fault:
            self._measurements.abort(self._trouble)
        else:
            self._measurements.add(raw, standing, dt)
        return [Output(topics.WRENCH_EXTERNAL, self._last, valid=not fault)]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """The last values, marked invalid; nothing before the first sample, since there is no value to give."""
        self._trouble = fault.text
        self._measurements.abort(fault.text)
        self._lowpass.reset()
        self._zero.silent(dt)
        if self._last is None:
            return []
        word = SILENT if fault.kind is FaultKind.SILENT else INVALID
        return [Output(topics.WRENCH_EXTERNAL, self._last.replaced(fault=word), valid=False)]

    def query(self, query: topics.Query, request: Record, reply: Reply) -> None:
        """Answer a tare or a step of an identification; what needs an average is answered in a later step."""
        if isinstance(request, SolveIdentification):
            declared, former = self._declared, self._former
            result, doubt = self._measurements.solve(
                request.force, declared.tilt, lambda found: payload_doubt(found, declared, former)
            )
            self._adopt(forced(result.compensation(), doubt, declared), self._identification_began)
            self._identification_began = None
            reply(described(result, self._saved(result), doubt))
        elif isinstance(request, (Tare, AddPose)):
            if self._trouble:
                raise Refused(self._trouble)
            zones = self._watch.zones
            coarsest = np.where(zones > 0.0, np.minimum(zones, self._bias_bound), self._bias_bound)
            bounds = self._noise_bound, self._resolution, coarsest
            self._measurements.begin(request, AveragingWindow(request.duration, *bounds), reply)
            # A bias is as old as the oldest reading in it.
            if isinstance(request, Tare):
                self._tare_began = self._zero.stamp
            elif self._identification_began is None:
                self._identification_began = self._zero.stamp
        else:
            self._identification_began = None
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
        self._watch.reweigh()
        if another:
            self._adopt(self.compensation, None)

    def files(self) -> dict[str, str]:
        """The payload's file, and the journal of the present compensation."""
        payload = {PAYLOAD: payload_text(self._configured_payload)} if self._configured_payload else {}
        return {JOURNAL: self._journal.text(self._session, self._entry()), **payload}

    def notes(self) -> str:
        """What a person should know of sensor, zero and files although the service works."""
        zero = self.compensation.warning and f"the zero was adopted by force: {self.compensation.warning}"
        unfit = self.parameters.unfit(self._period)
        notes = (self._trouble, self._watch.notes(), zero, self._refuted(), unfit, self._journal.problem)
        return "; ".join(filter(None, notes))

    def _refuted(self) -> str:
        """Which declared bounds the sensor itself has refuted."""
        known = self.compensation
        found = (
            # What a coarse sensor's steps hide counts as noise, and is declared by its resolution.
            ("noise_bound", self._noise_bound + np.array(self.parameters.resolution), known.noise),
            ("bias_bound", self._bias_bound, known.bias_bound),
            ("zero_drift", self._zero_drift, known.drift),
            ("tool_mass", np.array([self.parameters.tool_mass]), np.array([known.tool_mass])),
        )
        return "; ".join(
            f"{name} is refuted by what was measured, {np.round(measured, 3).tolist()} count"
            for name, declared, measured in found
            if np.any(measured > REFUTED * declared)
        )

    @property
    def _declared(self) -> Declared:
        settings = self.parameters
        return Declared(
            self._bias_bound, settings.tool_mass, settings.tool_reach, self._tool_offset, settings.floor_tilt + ATTITUDE
        )

    @property
    def _former(self) -> Former | None:
        """The zero of this run that another one can be held against."""
        if self._zero.age < 0.0 or self.compensation.kind == "none" or self.compensation.warning:
            return None
        return Former(self.compensation, self._error_of_bias, self._zero.age)

    @property
    def _error_of_bias(self) -> Array:
        known = self.compensation
        drift, most = np.maximum(self._zero_drift, known.drift), np.maximum(self._bias_bound, known.bias_bound)
        return bias_error(known, self._zero.age, drift, most)

    def _box(self, standing: Array) -> Array:
        """Bound (6,) on what is wrong with a reading and its bias, sensor axes."""
        box = np.maximum(self._noise_bound + self._resolution, self.compensation.noise) + self._error_of_bias
        box = box + np.minimum(self._watch.zones, self._bias_bound)
        return box + self.compensation.misfit(standing[2]) if self.compensation.kind == "payload" else box

    def _least_weight(self, standing: Array, offset: Array) -> Array:
        """Weight (6,) beyond the sensor: as identified, else what is there at least if anything is, sensor axes."""
        known = self.compensation
        if known.kind != "payload":
            known = lightest(self.parameters.tool_mass, self.parameters.tool_reach, *offset.tolist())
        return weight_of_up(known).dot(standing[2])

    def _configured(self, parameters: WrenchParameters, reload: bool) -> None:
        if reload:
            found = self._configured_payload = load_payload(Path(parameters.payload)) if parameters.payload else None
            self.compensation = found.compensation() if found else Compensation()
        self._noise_bound: Array = np.array(parameters.noise_bound)
        self._bias_bound: Array = np.array(parameters.bias_bound)
        self._zero_drift: Array = np.array(parameters.zero_drift)
        self._resolution: Array = np.array(parameters.resolution)
        self.max_delay = parameters.max_delay

    def _follow(self, session: int, stamp: int, dt: float) -> None:
        """A run of the robot process that was not seen before, by a sample with this stamp [ns].

        At the start of this service the journal may know of it, or of a payload. A run that ends another ends the zero
        with it: what is identified stays, with its bias for a first guess, and a tare, whose bias holds the weight too,
        is of no use.
        """
        if self._session is None:
            entry = self._journal.recall(session, self.parameters.payload)
            if entry is not None:
                known = entry.since is not None and entry.since <= stamp
                if known or entry.compensation.kind == "payload":
                    self.compensation, self._zero.since = entry.compensation, entry.since if known else None
        else:
            self._measurements.abort("the robot process was started anew")
            self._measurements.restart(start=False)
            self._identification_began = None
            self._lowpass.reset()
            self._zero.restarted(stamp, dt, self.parameters.zero_survives_restart)
            if self._zero.since is None and self.compensation.kind == "tare":
                self.compensation = Compensation()
        self._session = session
        self._watch = SensorWatch()
        self._record()

    def _tared(self, average: Average, request: Tare) -> Tared:
        """Subtract an average from now on.

        Raises:
            Refused: if it is no zero of a free tool, and not asked for by force.
        """
        known, declared, former = self.compensation, self._declared, self._former
        doubt = tare_doubt(average, known, declared, former)
        if doubt and not request.force:
            raise refusal(doubt)
        tared = known.tared(average.mean, average.mean_error, average.noise, average.rotation)
        tared = forced(tared, doubt, declared, former)
        replaced = self._zero.age
        self._adopt(tared, self._tare_began)
        return Tared(tared.bias[:3], tared.bias[3:], average.samples, average.std, replaced, doubt)

    def _adopt(self, compensation: Compensation, since: int | None) -> None:
        """Subtract this from now on; its bias is measured since a stamp [ns] of this run, if it is."""
        self.compensation, self._zero.since = compensation, since
        self._lowpass.reset()
        self._watch.reweigh()
        self._record()

    def _record(self) -> None:
        if self._session is not None:
            self._journal.record(self._session, self._entry())

    def _entry(self) -> JournalEntry:
        return JournalEntry(self.parameters.payload, self.compensation, self._zero.since)

    def _saved(self, result: IdentifiedPayload) -> str:
        """Where the result was written, empty if it could not be: it is in force all the same."""
        path = self.parameters.payload or (self._folder and self._folder / PAYLOAD)
        if path:
            try:
                save_payload(Path(path), result)
                return str(path)
            except Refused as problem:
                self._journal.problem = str(problem)
        return ""
