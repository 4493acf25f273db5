"""DDS for tests: domains that stay on this machine, and who listens in them."""

from __future__ import annotations

import random
import socket
from collections.abc import Callable

from cyclonedds.core import Listener
from cyclonedds.domain import DomainParticipant
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.util import duration

from services.ros_robot.dds_types import Encoded, topic

_DOMAINS = range(1, 100)  # their ports lie below those that the system gives away
_PORTS = 250  # of each domain, from 7400 on
_EVERY_ONE = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepAll)


def free_domain() -> int:
    """Number of a domain in which nobody is on this machine."""
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                # Where the first participant listens to others.
                probe.bind(("127.0.0.1", 7400 + _PORTS * domain + 10))
                return domain
            except OSError:
                continue
    raise AssertionError("every domain of DDS is taken")


def reader(participant: DomainParticipant, name: str, kind: str, heard: Callable[[bytes], None]) -> DataReader[Encoded]:
    """A reader of a topic, by its name in DDS, that hands over each message in a thread of its own."""

    class Hear(Listener):
        def on_data_available(self, reader: DataReader[Encoded] | None) -> None:
            # None if it has been deleted meanwhile.
            for sample in reader.take(N=10) if reader else ():
                if isinstance(sample, Encoded):
                    heard(sample.data)

    return DataReader(participant, topic(participant, name, kind), _EVERY_ONE, Hear())
