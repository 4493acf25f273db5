"""``python -m services.wrench``."""

import sys

from services.wrench.main import main

sys.exit(main())
