"""``python -m services.wrench``."""

from services.wrench.main import main
from shared.process import end

end(main())
