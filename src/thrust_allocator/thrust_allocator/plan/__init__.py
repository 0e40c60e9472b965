"""What every thruster may do in one step, and from the answer back to thrust and direction."""
