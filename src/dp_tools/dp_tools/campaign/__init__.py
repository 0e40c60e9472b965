"""Many runs: sailed by several processes, judged over seeds, told on one page."""
