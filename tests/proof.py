"""How much is proven: ``make test`` what a change can break, ``make test-all`` everything.

``ROBOT_PERCEPTION_PROOF=all`` asks for everything: types of every call, hypothesis at random, more
drawn trials, all pages. Tests with the mark ``slow`` run only then.
"""

import os
from pathlib import Path

PROOF = "ROBOT_PERCEPTION_PROOF"
"""Environment variable; the value ``all`` asks for the whole proof."""
WHOLE = os.environ.get(PROOF) == "all"
"""Whether everything is proven in this run."""
RECORD = Path(__file__).parent / "tools" / "minutes.json"
"""How long the proof took when it was last timed (`tests.tools.minutes`)."""
SECONDS = Path(__file__).parents[1] / "build" / "seconds.json"
"""How long each file of tests took in the last run here, the longest first."""
