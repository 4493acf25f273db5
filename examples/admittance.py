"""A controller of one's own: a plain admittance in place of `services/controller`, behind the robot's gate as that is.

Start `services.router`, `services.sim` and `services.wrench` with `python -m`, but no controller; then
`python -m examples.admittance --set damping=100`, `tandem tare`, and `tandem load 20` pulls it down.
"""

import numpy as np

from shared.loop.entry import end
from shared.loop.process import run
from shared.messages import TwistCommand
from shared.parameters import Parameters, parameter
from shared.service import Inputs, Output, Service, Wiring
from shared.topics import COMMAND_EE_TWIST, WRENCH_EXTERNAL

TTL = 0.05  # [s] for which the gate may execute a command: whatever goes wrong here, the tool stands after that


class AdmittanceParameters(Parameters):
    """How easily the tool gives way."""

    damping: float = parameter(100.0, "N s/m", 20.0, 10000.0, "force per speed")


class Admittance(Service[AdmittanceParameters]):
    """Moves the tool along the force that acts on it, as far as that exceeds what the sensor may be wrong by."""

    wiring = Wiring(name="controller", driver=WRENCH_EXTERNAL, required=(WRENCH_EXTERNAL,))

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """One command per wrench; while an input is missing there is none, and the gate brakes."""
        wrench = inputs[WRENCH_EXTERNAL].message
        felt = np.sign(wrench.force) * np.maximum(np.abs(wrench.force) - wrench.error_bound[:3], 0.0)
        return [Output(COMMAND_EE_TWIST, TwistCommand(felt / self.parameters.damping, np.zeros(3), TTL))]


if __name__ == "__main__":
    end(run(Admittance, AdmittanceParameters, "controller"))
