"""`dp compare`: what published allocation methods give away against the exact attainable set and the constrained QP."""
