"""The unobservable monobot: Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.2."""
