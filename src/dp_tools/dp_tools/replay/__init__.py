"""Messages of a bag, sent again as they were sent."""
