"""What turns results into a book: figures, explorers, claims, exercises, shown source."""

from robot_perception.extras import need

need("matplotlib", "anywidget", "PIL")
