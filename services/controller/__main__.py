"""``python -m services.controller``."""

from services.controller.main import main
from shared.process import end

end(main())
