"""What scripts that `studies.costs.costs.under_yade` starts begin and end with; SPECIFICATION RESULT (JSON files)."""

import json
import os
import sys


def serve(answer):
    """Write what `answer` makes of the specification, and end YADE at once."""
    with open(sys.argv[-2]) as file:
        given = json.load(file)
    hand_over(answer(given))


def hand_over(found):
    """Write what was found to RESULT; YADE's own end takes seconds, and loses the exit status."""
    with open(sys.argv[-1], "w") as file:
        json.dump(found, file)
    sys.stdout.flush()
    os._exit(0)
