"""Re-execution: recorded inputs fed to the present code of a node, and its outputs compared with the recorded ones."""
