"""How much is proven: ``make test`` what a change can break, ``make test-all`` everything.

``ROBOT_PERCEPTION_PROOF=all`` asks for everything: types of every call, hypothesis at random, more
drawn trials, all pages. Tests with the mark ``slow`` run only then.
"""

import os

PROOF = "ROBOT_PERCEPTION_PROOF"
"""Environment variable; the value ``all`` asks for the whole proof."""
WHOLE = os.environ.get(PROOF) == "all"
"""Whether everything is proven in this run."""
