"""Recording of a whole run to one MCAP bag that every ROS 2 tool opens."""

# Name of the node that holds the recorder's subscriptions; hidden, as it is nobody's to talk to.
RECORDER_EARS = "_recorder_ears"
# In what is said when a recording comes to its end by itself.
STOPPED_WORDS = "recording stopped"
