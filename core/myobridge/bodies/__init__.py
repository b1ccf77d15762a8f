"""Bodies: pictures of the deformed tissue, flat or in space, coloured by a field, several states side by side."""

from myobridge.bodies.choice import Colouring, choose_field, choose_states
from myobridge.bodies.picture import ENGINES, draw_body
from myobridge.bodies.skin import Skin, nodal_means, skin

__all__ = ["ENGINES", "Colouring", "Skin", "choose_field", "choose_states", "draw_body", "nodal_means", "skin"]
