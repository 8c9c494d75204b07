"""Trackers that know an object by its colours and its outline, alone or together."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "affine_snake": ("Affine", "SnakeRules"),
        "colour_distribution": ("ColourDistribution", "Dynamics"),
        "colour_histograms": (),
        "colour_shape": ("ColourShapeRules", "ColourShapeTracker"),
        "colour_spaces": ("SPACES", "Binning", "ColourSpace"),
        "head_ellipse": ("Ellipse", "HeadRules", "HeadTracker"),
        "segmentation": ("Blob",),
        "shape_scores": (),
        "single_cues": ("ColourTracker", "EdgeTracker", "WindowTracker"),
    },
    import_module,
)
