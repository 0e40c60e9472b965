"""`dp status`: what vessel, thrusters and nodes are doing, on one screen."""
