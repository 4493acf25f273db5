"""``python -m services.experiment``."""

import sys

from services.experiment.main import main

sys.exit(main())
