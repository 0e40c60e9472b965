"""The operator's tools: run the graph, record it, report on it."""
