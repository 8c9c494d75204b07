"""A head by its colours: section 3.2 of Andrade-Cetto, "Perception Issues in Mobile Robotics"."""
