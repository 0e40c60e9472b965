"""Bags as files: read, judged, repaired, cut and turned into tables, whoever wrote them."""
