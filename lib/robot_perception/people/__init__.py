"""People around a robot are detected by legs, sonar, skin and voice, and followed as one crowd."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "aggregation": ("AggregationRules", "Aggregator", "Hypotheses", "SensorRules"),
        "behaviours": ("Behaviours", "Command"),
        "detections": ("Detections", "polar"),
        "legs": ("LegRules",),
        "robot": ("ServiceRobot",),
        "scores": ("Frame", "gospa", "score"),
        "skin": ("SkinModel", "SkinRules", "SkinTracker"),
        "sonar": ("SonarRules",),
        "sound": ("SoundRules",),
        "tracker": ("PeopleTracker",),
        "trajectories": ("StaticRules", "Stays", "Trajectory"),
        "verification": ("Verifier",),
    },
    import_module,
)
