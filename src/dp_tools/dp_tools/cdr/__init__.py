"""Serialized ROS 2 messages in bulk: many of one layout are one array."""
