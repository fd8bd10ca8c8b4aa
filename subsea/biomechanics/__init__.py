"""The muscle-driven fish: body, water forces, solver and motor controllers (Tu ch. 4).

Units here are those of Tu's constants: centimetre, gram and the *time unit* ``tu`` of 0.1 s.
"""
