"""``python -m services.experiment``."""

from services.experiment.main import main
from shared.process import end

end(main())
