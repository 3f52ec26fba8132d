"""python -m demlaws"""

import sys

from demlaws.cli import main

sys.exit(main())
