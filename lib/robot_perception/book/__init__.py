"""The notebooks as modules: ``robot_perception.book.<stem>`` is the study cells of a chapter.

``from robot_perception.book.tutor_face import bridged`` gives a worker, a test, the command line or
another notebook what a reader of ``book/tutor_face.ipynb`` reads and edits: they are found by
:mod:`studies.notebooks`.
"""

from studies.notebooks import install

install(__name__)
