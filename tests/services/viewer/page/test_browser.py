"""The page in a real browser, before a simulated robot: what a person sees, and what becomes of what the person does.

Skipped by name where there is no browser; with TANDEM_BROWSER=required, as in .ci/run, it fails instead.
"""

from __future__ import annotations

import io
import os
import signal
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from shared.messages import LONGEST_TTL, ControlStatus, RobotStatus, TwistCommand
from shared.topics import COMMAND_EE_TWIST, CONTROL_STATUS, STATE_ROBOT
from tests.conftest import Router, StartProcess, _processes, _router
from tests.services.viewer.page.test_process import Viewer
from tests.support import browser
from tests.support.browser import Window
from tests.support.stand_in import StandIn

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(900)]

ZERO = (0.0,) * 6
LIMIT = (25.0, 25.0, 25.0, 10.0, 10.0, 10.0)


class Controller(StandIn):
    """Says that it tracks, or that z force holds it back; it moves nothing."""

    def __init__(self, endpoint: str) -> None:
        self.held = False
        super().__init__(endpoint, "viewer", self._says, period=0.05)

    def _says(self, number: int) -> Iterable[tuple[Any, ...]]:
        margin = (20.0, 20.0, 0.2 if self.held else 20.0, 8.0, 8.0, 8.0)
        active = (0, 0, int(self.held), 0, 0, 0)
        state = "yielding" if self.held else "tracking"
        yield COMMAND_EE_TWIST, TwistCommand(ZERO[:3], ZERO[:3], ttl=LONGEST_TTL)
        yield CONTROL_STATUS, ControlStatus(state, "", "certified", ZERO, margin, active, 0.0, 0.0, 0.0, LIMIT, ZERO)


@pytest.fixture(scope="module")
def start(tmp_path_factory: pytest.TempPathFactory) -> Iterator[StartProcess]:
    if why := browser.unusable():
        (pytest.fail if os.environ.get("TANDEM_BROWSER") == "required" else pytest.skip)(why)
    with _processes(tmp_path_factory.mktemp("browser")) as start_process:
        yield start_process


@pytest.fixture(scope="module")
def router(start: StartProcess) -> Router:
    return _router(start)


@pytest.fixture(scope="module")
def viewer(start: StartProcess, router: Router) -> Viewer:
    start("services.sim", "--connect", router.endpoint)
    return Viewer(start, router.endpoint)


@pytest.fixture(scope="module")
def controller(router: Router) -> Iterator[Controller]:
    with Controller(router.endpoint) as controller:
        yield controller


@pytest.fixture
def window() -> Iterator[Window]:
    with Window() as window:
        yield window


@pytest.fixture
def hands(window: Window, viewer: Viewer, controller: Controller) -> Iterator[Window]:
    """The page of the hands, with a robot that may move."""
    controller.held = False
    window.driver.get(f"http://{viewer.host}/hands")
    window.until(lambda: window.at("hands").is_displayed(), lambda: window.text("no-hands"))
    yield window
    viewer.does("/release")


def colours(window: Window, box: tuple[float, float, float, float]) -> int:
    """How many colours a part of the picture has; its edges are shares of the whole (left, upper, right, lower)."""
    shot = Image.open(io.BytesIO(window.driver.get_screenshot_as_png())).convert("RGB")
    frame = window.at("picture").rect
    part = (
        frame["x"] + box[0] * frame["width"],
        frame["y"] + box[1] * frame["height"],
        frame["x"] + box[2] * frame["width"],
        frame["y"] + box[3] * frame["height"],
    )
    return len(shot.crop(tuple(map(round, part))).getcolors(1 << 24) or ())  # type: ignore[arg-type]


def test_the_picture_is_drawn_and_the_sentence_says_which_limit_is_reached(
    window: Window, viewer: Viewer, controller: Controller
) -> None:
    window.driver.get(f"http://{viewer.host}/")
    window.until(lambda: "nothing holds it back" in window.text("sentence"), lambda: window.text("sentence"))
    # A plain surface has few colours; shaded bodies have hundreds, and curves with their axes dozens.
    window.until(lambda: colours(window, (0.0, 0.3, 0.5, 0.9)) > 300, "the scene is drawn")
    window.until(lambda: colours(window, (0.6, 0.5, 1.0, 0.9)) > 40, "the plots are drawn")
    window.until(lambda: not window.at("old").is_displayed(), "drawing holds up nothing else for good")
    controller.held = True
    window.until(lambda: "z force" in window.text("sentence"), lambda: window.text("sentence"))
    assert "24.8 of 25 N" in window.text("sentence")
    assert window.at("why").get_attribute("data-kind") == "held"
    asked = [line for line in window.outside.asked if any(name in line for name in ("rerun", "github", "fonts"))]
    assert not asked, "nobody is told of it"


def test_the_hands_are_led_by_keys_and_by_dragging(hands: Window, viewer: Viewer) -> None:
    hands.button("[data-script=take]").click()
    hands.until(lambda: viewer.state()["hand"])

    def wanted(axis: int) -> float:
        return viewer.state()["hand"]["wanted"][axis]

    for key, axis, sign in ((Keys.ARROW_LEFT, 1, 1), (Keys.ARROW_RIGHT, 1, -1), (Keys.PAGE_UP, 2, 1)):
        before = wanted(axis)
        ActionChains(hands.driver).key_down(key).perform()
        hands.until(lambda axis=axis, sign=sign, before=before: sign * (wanted(axis) - before) > 0.03, key)
        ActionChains(hands.driver).key_up(key).perform()
    before = wanted(0)
    pad = hands.at("above")
    ActionChains(hands.driver).move_to_element(hands.at("hand")).click_and_hold().move_by_offset(0, 40).perform()
    hands.until(lambda: wanted(0) < before - 0.03, "towards the robot, which is below")
    ActionChains(hands.driver).release().perform()
    assert pad.is_displayed() and "N" in hands.at("newton").find_element("xpath", "..").text
    assert hands.text("doing") == "guided"


@pytest.mark.parametrize("how", ["key", "button"])
def test_a_stop_stops_the_robot_and_a_release_lets_it_go(hands: Window, viewer: Viewer, how: str) -> None:
    if how == "key":
        ActionChains(hands.driver).send_keys(Keys.ESCAPE).perform()
    else:
        hands.at("stop").click()
    hands.until(viewer.shows("stopped"))
    hands.until(lambda: "stopped: the robot shows it" in hands.text("answer"), lambda: hands.text("answer"))
    hands.until(lambda: "STOP on the page" in hands.text("sentence"))
    hands.at("release").click()
    hands.until(lambda: not viewer.shows("stopped")())
    hands.until(lambda: "released" in hands.text("answer"))


def test_it_works_without_a_mouse_and_the_stop_is_there_at_every_width(hands: Window) -> None:
    reached = []
    for _ in range(12):
        ActionChains(hands.driver).send_keys(Keys.TAB).perform()
        focused = hands.driver.switch_to.active_element
        reached.append(focused.get_attribute("id") or focused.get_attribute("data-command"))
    assert {"stop", "release", "start", "abort"} <= {*reached}
    for width, height in ((1600, 900), (400, 800), (320, 500)):
        hands.resize(width, height)
        hands.driver.execute_script("window.scrollTo(0, document.body.scrollHeight)")
        seen = hands.driver.execute_script("""
            const box = document.getElementById("stop").getBoundingClientRect();
            const over = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
            return [Boolean(over?.closest("#stop")), document.body.scrollWidth <= innerWidth, box.width, box.height];
        """)
        assert seen[:2] == [True, True], (width, seen)
        assert min(seen[2:]) >= 44.0, "a finger finds it"


def test_an_answer_in_the_robot_s_words_and_nobody_there(hands: Window) -> None:
    hands.button("[data-command=start]").click()
    hands.until(lambda: "task is not running" in hands.text("answer"), lambda: hands.text("answer"))
    assert "bad" in (hands.at("answer").get_attribute("class") or "")


def test_a_viewer_that_is_gone_is_told_in_red_and_the_stop_says_so(
    start: StartProcess, router: Router, hands: Window, viewer: Viewer
) -> None:
    viewer.process.signal(signal.SIGSTOP)
    try:
        # All at once: an answer that was under way may still make a picture fresh that a busy machine held up.
        hands.until(
            lambda: (
                "This picture is old" in hands.text("old")
                and "STOP cannot reach the robot" in hands.text("old")
                and hands.text("stop") == "STOP cannot reach the robot"
                and hands.at("release").get_attribute("disabled")
            ),
            lambda: f"{hands.text('old')} {hands.text('stop')}",
        )
        hands.at("stop").click()
        hands.until(lambda: "STOP cannot reach the robot: stop it by its own button" in hands.text("answer"))
    finally:
        viewer.process.signal(signal.SIGCONT)
    hands.until(lambda: not hands.at("old").is_displayed())
    hands.until(viewer.shows("stopped"), "what was pressed meanwhile arrives")


def test_another_viewer_at_the_same_address_is_another_page(
    start: StartProcess, router: Router, window: Window, tmp_path: Path
) -> None:
    first = Viewer(start, router.endpoint)
    window.driver.get(f"http://{first.host}/hands")
    window.until(lambda: not window.at("old").is_displayed())
    window.driver.execute_script("window.before = true")
    first.process.kill()
    window.until(lambda: window.at("old").is_displayed())
    start("services.viewer", "--connect", router.endpoint, "--port", str(first.port))
    window.until(lambda: not window.driver.execute_script("return window.before"), "it was loaded anew")
    window.until(lambda: not window.at("old").is_displayed())


class Hardware(StandIn):
    """A robot that is no simulation."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(endpoint, "viewer", self._says, period=0.1)

    def _says(self, number: int) -> Iterable[tuple[Any, ...]]:
        yield STATE_ROBOT, RobotStatus("ready", "", "omni", False, 0.25, 1.0, (0.5, 0.5, 1.0))


def test_beside_a_real_robot_the_hands_are_the_person_s_own(start: StartProcess, window: Window) -> None:
    router = _router(start)
    viewer = Viewer(start, router.endpoint)
    with Hardware(router.endpoint):
        window.driver.get(f"http://{viewer.host}/hands")
        window.until(lambda: "only a simulation has hands" in window.text("no-hands"))
        assert not window.at("hands").is_displayed() and window.at("stop").is_displayed()
