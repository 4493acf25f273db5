"""Controllers of the robot: which ones run, those of the profile switched in at the start, and back at the end."""

from __future__ import annotations

import threading
from collections.abc import Collection, Mapping
from typing import Any

from services.bridge_ros1 import controller_manager as manager
from shared.robot.profile import Profile

PATIENCE = 1.5
"""Longest time [s] for an answer of the controller manager."""
RUNNING = "running"


class NoAnswer(Exception):
    """A service did not do what it was asked; the text says why."""


class Switching:
    """What the controller manager says and is told; only ``look`` and ``back`` ask it, and wait for it.

    Attributes:
        trouble: why a controller that the profile names would not carry out what it is told; empty if all would.

    Args:
        profile: of the robot.
        read_only: nothing is switched.
    """

    def __init__(self, profile: Profile, read_only: bool) -> None:
        wanted = profile.switching
        self._start, self._stop = (wanted.start, wanted.stop) if wanted and not read_only else ((), ())
        self._service = wanted.service if wanted else "/controller_manager/switch_controller"
        self._list = self._service.rpartition("/")[0] + "/list_controllers"
        self._needed = {controller.controller: name for name, controller in profile.controllers.items()}
        self._asked_for = wanted is not None
        self._begun = False
        self._started: list[str] = []
        self._stopped: list[str] = []
        self.trouble = "the controllers of the robot are not known yet" if wanted else ""

    def look(self, services: Collection[str]) -> None:
        """Ask which controllers run, and the first time switch those of the profile in.

        Args:
            services: that there are.
        """
        if self._list not in services:
            if self._asked_for:
                self.trouble = f"the robot has no service {self._list}: is its controller manager up?"
            return
        try:
            states = self._states()
            if not self._begun:
                self._begin(states)
                states = self._states()
            self.trouble = self._not_running(states)
        except NoAnswer as problem:
            self.trouble = str(problem)

    def back(self) -> None:
        """Undo what was switched, as far as the controller manager answers."""
        if self._started or self._stopped:
            try:
                self._switch(start=self._stopped, stop=self._started)
            except NoAnswer as problem:
                self.trouble = str(problem)
            self._started, self._stopped = [], []

    def _begin(self, states: Mapping[str, str]) -> None:
        start = [name for name in self._start if states.get(name) != RUNNING]
        stop = [name for name in self._stop if states.get(name) == RUNNING]
        if absent := [name for name in start if name not in states]:
            raise NoAnswer(f"controllers to start are not loaded on the robot: {', '.join(absent)}")
        if start or stop:
            self._switch(start, stop)
        # Once: what somebody else switches afterwards stays as it is, and nothing moves.
        self._begun, self._started, self._stopped = True, start, stop

    def _switch(self, start: list[str], stop: list[str]) -> None:
        request = {"start_controllers": start, "stop_controllers": stop, "strictness": manager.STRICT}
        if not call(self._service, manager.SWITCHES, request).ok:
            wanted = [*(f"start {name}" for name in start), *(f"stop {name}" for name in stop)]
            raise NoAnswer(
                f"the controller manager refuses to {', '.join(wanted)}: another controller has those joints?"
            )

    def _states(self) -> Mapping[str, str]:
        return manager.states(call(self._list, manager.LISTS, {}))

    def _not_running(self, states: Mapping[str, str]) -> str:
        still = {name: states.get(name, "not loaded") for name in self._needed if states.get(name) != RUNNING}
        return ", ".join(f"the controller {name} is {state}" for name, state in still.items())


def call(service: str, definitions: tuple[manager.Definition, ...], request: Mapping[str, Any]) -> Any:
    """The answer of a service, of whichever of its definitions the robot has.

    Raises:
        NoAnswer: it refused, or was silent for ``PATIENCE``.
    """
    answer: list[Any] = []
    thread = threading.Thread(target=lambda: answer.append(_ask(service, definitions, request)), daemon=True)
    thread.start()
    thread.join(PATIENCE)
    if not answer:
        raise NoAnswer(f"the service {service} has not answered for {PATIENCE:g} s")
    if isinstance(answer[0], Exception):
        raise NoAnswer(f"the service {service} does not answer: {answer[0]}")
    return answer[0]


def _ask(service: str, definitions: tuple[manager.Definition, ...], request: Mapping[str, Any]) -> Any:
    import rospy

    problem: Exception = ValueError("no definition")
    for definition in definitions:
        kind = manager.service_class(definition)
        try:
            return rospy.ServiceProxy(service, kind)(kind._request_class(**request))
        except Exception as failure:
            problem = failure
            if "md5sum" not in str(failure):
                break
    return problem
