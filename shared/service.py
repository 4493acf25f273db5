"""Base of every service: two pure methods, and a statement of what they are connected to."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from shared.faults import Fault
from shared.messages import Header
from shared.parameters import Parameters, Refused
from shared.schema.records import Record
from shared.topics import Query, Topic

M = TypeVar("M", bound=Record)
P = TypeVar("P", bound=Parameters)
LONGEST_DT = 0.1
"""Largest dt [s] that a step is told: what was missed is never caught up."""
Reply = Callable[[Record | Refused], None]
"""Answers a query, with a refusal if what was begun could not be finished."""


@dataclass(slots=True)
class Output:
    """One message to publish.

    Attributes:
        valid: false marks the message as not to be trusted.
        late: age [s] of its content already; its stamp says so.
        payload: sent in place of the encoded message. The simulation plays a broken sensor with it.
    """

    topic: Topic
    message: Record
    valid: bool = True
    late: float = 0.0
    payload: bytes | None = None


@dataclass(frozen=True)
class Wiring:
    """Connections of a service.

    Attributes:
        name: the service's name.
        driver: the topic whose every new message causes a step, or a period [s].
        required: topics that have to be healthy for a step; otherwise the service brakes.
        optional: topics that are handed over if they are healthy in form, whatever their age.
        occasional: optional topics that cost their publisher something: subscribed to only while the function beside
            each, asked after every step, says that they are of use, and each time as if for the first time.
        on_demand: topics that are worth publishing only while somebody subscribes; ``Inputs.wanted`` tells.
        shares: topics that it publishes and others may too, one at a time; ``Inputs.taken`` tells whose turn it is.
        queries: queryables that the service answers itself.
        parameters: queryable of its parameters, if it has one.
        startup: time [s] that all required inputs have to be healthy before the first step.
        overrun_share: share [1] of late steps within a second above which the service brakes.
    """

    name: str
    driver: Topic | float
    required: tuple[Topic, ...] = ()
    optional: tuple[Topic, ...] = ()
    occasional: Mapping[Topic, Callable[[], bool]] = field(default_factory=dict)
    on_demand: tuple[Topic, ...] = ()
    shares: tuple[Topic, ...] = ()
    queries: tuple[Query, ...] = ()
    parameters: Query | None = None
    startup: float = 0.5
    overrun_share: float = 0.05


@dataclass(slots=True)
class Reading(Generic[M]):
    """An input as a step sees it: message, header, age [s], and whether this is the first step to see it."""

    message: M
    header: Header
    age: float
    new: bool


@dataclass
class Inputs:
    """The newest messages at the instant of a step.

    Attributes:
        cut_off: why nobody but the processes of the chain can reach the service, a stop neither; empty if they can.
        links: whether there is a direct link to each other process of the chain, up to half a second ago.
    """

    _readings: dict[str, Reading] = field(default_factory=dict)
    _refusals: dict[str, str] = field(default_factory=dict)
    _wanted: frozenset[str] = frozenset()
    _refused: dict[str, str] = field(default_factory=dict)
    _taken: dict[str, str] = field(default_factory=dict)
    cut_off: str = ""
    links: Mapping[str, bool] = field(default_factory=dict)

    def __getitem__(self, topic: Topic[M]) -> Reading[M]:
        return self._readings[topic.key]

    def get(self, topic: Topic[M]) -> Reading[M] | None:
        """The reading, or None if no message was accepted since the subscription."""
        return self._readings.get(topic.key)

    def wanted(self, topic: Topic) -> bool:
        """Whether anybody subscribes to one of the wiring's ``on_demand`` topics."""
        return topic.key in self._wanted

    def refusals(self, topic: Topic) -> str:
        """Refusals on the topic since the subscription, in words; empty if there are none."""
        return self._refusals.get(topic.key, "")

    def refused(self, topic: Topic) -> str:
        """Why nothing of what arrives on the topic at present is used; empty if it is, or nothing arrives."""
        return self._refused.get(topic.key, "")

    def taken(self, topic: Topic) -> str:
        """Name of who publishes one of the wiring's ``shares`` too and was first, while the service publishes it."""
        return self._taken.get(topic.key, "")


class Service(ABC, Generic[P]):
    """A service, as the loop runs it. It sees no clock, no bus and no log.

    Attributes:
        wiring: what it is connected to.
        parameters: in force.
        max_delay: bound [s] on how much later than the fastest one a message may arrive.
        renewed: set by a query to the topics that begin a new session with it; the loop takes it and clears it.
    """

    wiring: Wiring
    max_delay: float = 0.2
    renewed: tuple[Topic, ...] = ()

    def __init__(self, parameters: P) -> None:
        self.parameters = parameters

    @abstractmethod
    def step(self, inputs: Inputs, dt: float) -> Iterable[Output]:
        """One step with healthy inputs, ``dt`` [s] after the last call; commands first.

        Each output is sent as soon as it is there: what a generator makes after a command does not delay it.
        """

    def brake(self, fault: Fault, dt: float) -> Iterable[Output]:
        """Messages to publish because of a fault, ``dt`` [s] after the last call."""
        return ()

    def query(self, query: Query, request: Record, reply: Reply) -> None:
        """Answer a query of the wiring now or in a later step.

        Raises:
            Refused: with the reason.
        """
        raise Refused(f"{query.key} is not served by {self.wiring.name}")

    def apply(self, parameters: P) -> None:
        """Take over parameters that have been checked.

        Raises:
            Refused: with the reason; nothing is changed then.
        """
        self.parameters = parameters

    def files(self) -> Mapping[str, str]:
        """Content by name of what a new start would find in the service's folder, and work by; asked now and then."""
        return {}

    def close(self) -> None:
        """Let go of what is no bus, such as hardware; called once, after the last ``brake``."""
        return None

    def notes(self) -> str:
        """Remarks for a human although the service works; empty if there are none."""
        return ""
