"""`python -m services.cli` is the same as `tandem`."""

from services.cli.main import app

app()
