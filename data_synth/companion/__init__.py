"""People before a robot's camera: faces, hands, clothed walkers, and a room behind them."""
