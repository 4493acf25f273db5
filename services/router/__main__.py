"""``python -m services.router``."""

from services.router.main import main
from shared.process import end

end(main())
