"""How far shaft speed, thrust, torque and power stray from what is asked as the advance speed rises, [Ruth] 3.5.

``closed_form`` has the thesis's formulas, ``numerical`` the equilibrium of control law and propeller by root finding;
they agree where the formulas are exact.
"""

from thruster_drivers.sensitivity.sensitivity import NominalCoefficients, Sensitivity, nominal_coefficients

__all__ = ["NominalCoefficients", "Sensitivity", "nominal_coefficients"]
