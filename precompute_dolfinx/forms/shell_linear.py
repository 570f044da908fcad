"""Hooke's law in plane stress. The energy of St. Venant-Kirchhoff is that of the linear theory where strains are of
first order: with C = 1 + 2 e its invariants give tr e and tr(e^2).
"""

from shell import every_form
from shell_st_venant_kirchhoff import *

globals().update(every_form(plane_stress, mu, finite=False))
