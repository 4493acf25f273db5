"""A real browser without a window: what a person sees of a page, and does there."""

from __future__ import annotations

import importlib.util
import shutil
import socket
import threading
from collections.abc import Callable
from typing import TypeVar

from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.wait import WebDriverWait

T = TypeVar("T")
PATIENCE = 120.0
"""Longest wait [s] for what has to be seen: a picture drawn without a graphics card takes its time."""
_PROGRAMS = (("chromium", "chromium"), ("chromedriver", "chromium-driver"))


def unusable() -> str:
    """Why there is no browser to be had here; empty if there is one."""
    missing = [package for program, package in _PROGRAMS if shutil.which(program) is None]
    if importlib.util.find_spec("rerun_cli") is None:
        return "rerun-sdk is not installed"
    return f"there is no browser for tests: apt-get install {' '.join(missing)}" if missing else ""


class Outside:
    """The only way out that the browser has: notes who is asked for, and lets nobody through."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            with connection:
                connection.settimeout(5.0)
                try:
                    self.asked.append(connection.recv(1000).split(b"\r\n")[0].decode("latin-1"))
                except OSError:
                    continue

    def close(self) -> None:
        """Note nothing more."""
        self._listener.close()


class Window:
    """A browser of a size [px], whose way out is one that a test looks at; a context manager that ends it."""

    def __init__(self, width: int = 1600, height: int = 900, dark: bool = False) -> None:
        self.outside = Outside()
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium") or ""
        for argument in (
            "headless=new",
            "no-sandbox",
            "no-first-run",
            "use-angle=swiftshader",
            "enable-unsafe-swiftshader",
            f"proxy-server={self.outside.address}",
            "proxy-bypass-list=127.0.0.1;localhost",
        ):
            options.add_argument(f"--{argument}")
        self.driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver") or ""))
        self.resize(width, height)
        colours = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [colours]})

    def resize(self, width: int, height: int) -> None:
        """Change the size of the page [px]."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    def at(self, name: str) -> WebElement:
        """An element by its id."""
        return self.driver.find_element(By.ID, name)

    def button(self, selector: str) -> WebElement:
        """An element by what CSS calls it."""
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def text(self, name: str) -> str:
        """What an element says."""
        return self.at(name).text

    def until(self, condition: Callable[[], T], message: str | Callable[[], str] = "") -> T:
        """The first truthy value of a condition.

        Raises:
            TimeoutException: with what was awaited.
        """
        wait: WebDriverWait = WebDriverWait(
            self.driver, PATIENCE, poll_frequency=0.1, ignored_exceptions=[StaleElementReferenceException]
        )
        try:
            return wait.until(lambda _: condition())
        except Exception as problem:
            raise AssertionError(message() if callable(message) else message or repr(problem)) from problem

    def __enter__(self) -> Window:
        return self

    def __exit__(self, *_: object) -> None:
        self.driver.quit()
        self.outside.close()
