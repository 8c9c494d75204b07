"""Faces are found, recognised and followed, and the one is kept that began."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "detection": ("FaceDetector",),
        "eigenfaces": ("Eigenfaces", "Recognition", "enrol"),
        "gallery": ("Gallery",),
        "icondensation": ("FaceFilter", "FaceFilterRules"),
        "link": ("Link", "LinkRules", "SeenFace", "keep_link"),
        "region": ("FaceTracker", "RegionRules"),
    },
    import_module,
)
