"""Recording of a whole run to one MCAP bag that every ROS 2 tool opens."""
