"""Services of ROS 1's controller manager, made from their definitions: Debian does not package them.

Robots have one of two requests to switch: since 2019 it has two more fields, and with them another checksum. A node
refuses the other one, so both are here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

_PACKAGE = "controller_manager_msgs"
_SWITCH = "string[] start_controllers\nstring[] stop_controllers\nint32 strictness\n"
_CONSTANTS = "int32 BEST_EFFORT=1\nint32 STRICT=2\n"
_STATE = "string name\nstring state\nstring type\n"
STRICT = 2
"""Switch all controllers or none."""


@dataclass(frozen=True)
class Definition:
    """Request and reply of a service, and the messages that are inside, innermost first."""

    name: str
    request: str
    reply: str
    inside: tuple[tuple[str, str], ...] = ()


SWITCHES = (
    Definition("SwitchController", f"{_CONSTANTS}{_SWITCH}bool start_asap\nfloat64 timeout\n", "bool ok\n"),
    Definition("SwitchController", _CONSTANTS + _SWITCH, "bool ok\n"),
)
"""Newest first."""
LISTS = (
    Definition(
        "ListControllers",
        "",
        f"{_PACKAGE}/ControllerState[] controller\n",
        (
            ("HardwareInterfaceResources", "string hardware_interface\nstring[] resources\n"),
            ("ControllerState", f"{_STATE}{_PACKAGE}/HardwareInterfaceResources[] claimed_resources\n"),
        ),
    ),
    Definition(
        "ListControllers",
        "",
        f"{_PACKAGE}/ControllerState[] controller\n",
        (("ControllerState", f"{_STATE}string hardware_interface\nstring[] resources\n"),),
    ),
)
"""Newest first."""


@cache
def service_class(definition: Definition) -> Any:
    """The class for rospy of a service, with its checksum as every node computes it."""
    from genmsg import gentools, msg_loader
    from genpy.dynamic import generate_dynamic

    context, kind = msg_loader.MsgContext.create_default(), f"{_PACKAGE}/{definition.name}"
    for name, text in definition.inside:
        msg_loader.load_msg_from_string(context, text, f"{_PACKAGE}/{name}")
    spec = msg_loader.load_srv_from_string(context, f"{definition.request}---\n{definition.reply}", kind)
    further = "".join(f"{'=' * 80}\nMSG: {_PACKAGE}/{name}\n{text}" for name, text in definition.inside)
    classes: dict[str, Any] = {}
    for part, text in (("Request", definition.request), ("Response", definition.reply + further)):
        classes |= generate_dynamic(f"{kind}{part}", text)
    parts = {
        "_type": kind,
        "_md5sum": gentools.compute_md5(context, spec),
        "_request_class": classes[f"{kind}Request"],
        "_response_class": classes[f"{kind}Response"],
        "_classes": classes,
    }
    return type(definition.name, (), parts)


def states(reply: Any) -> Mapping[str, str]:
    """State of each controller by its name, such as ``running``."""
    return {str(controller.name): str(controller.state) for controller in reply.controller}
