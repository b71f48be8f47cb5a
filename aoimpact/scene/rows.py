"""The layout of a record: its rows, as both integrators of the core write them.

For each contact force, indentation, energy stored in the law and energy lost in it; then for each
body displacement and velocity of its centre of mass, kinetic energy, strain energy, energy lost in
its damping and work on it; then for each of its ports displacement and velocity.
"""

__all__ = ["BODY_ROWS", "CONTACT_ROWS", "PORT_ROWS"]

# AOI_CONTACT_ROWS, AOI_BODY_ROWS and AOI_PORT_ROWS of the core.
CONTACT_ROWS, BODY_ROWS, PORT_ROWS = 4, 6, 2
