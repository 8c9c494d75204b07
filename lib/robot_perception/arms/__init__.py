"""Two arms from one camera: a model of the body, likelihoods, and a tracker."""
