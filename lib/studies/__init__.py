"""Studies: functions of one trial, rows that are recorded, claims whose verdicts follow."""

from studies.project import Project, use

__all__ = ["Project", "use"]
