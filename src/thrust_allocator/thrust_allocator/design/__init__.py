"""The design loop of [Ruth] 7.5.4: gains of every combination of thrusters, power buses, maps."""
