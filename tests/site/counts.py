"""What the site tests count, line by line of their summary."""

COUNTS = (
    "pages opened",
    "explorers driven",
    "controls driven to both ends",
    "states shown",
    "explorers alive after Run All Cells",
    "requests to other hosts",
    "console errors and page errors",
    "serious or critical violations, light",
    "serious or critical violations, dark",
)
