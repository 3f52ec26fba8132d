"""What programs that `studies.engines.under_yade` starts begin and end with; SPECIFICATION RESULT (JSON files)."""

import json
import os
import sys


def serve(answer):
    """Write what `answer` makes of the specification; YADE's own end takes seconds, and loses the exit status."""
    with open(sys.argv[-2]) as file:
        found = answer(json.load(file))
    with open(sys.argv[-1], "w") as file:
        json.dump(found, file)
    sys.stdout.flush()
    os._exit(0)
