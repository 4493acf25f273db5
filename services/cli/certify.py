"""`tandem certify`: what the certified law guarantees with the present configuration."""

from __future__ import annotations

import os
import sys

import typer

from services.cli.children import command

CONTEXT = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}


def certify(context: typer.Context) -> None:
    """Certified speeds, worst excess and what limits them; options as of python -m services.controller.certify."""
    sys.stdout.flush()
    os.execv(sys.executable, command("controller.certify", context.args))
