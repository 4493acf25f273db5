"""``python -m services.sim``."""

from services.sim.main import main
from shared.process import end

end(main())
