"""The muscle-driven fish: body, water forces, solver and motor controllers (Tu ch. 4).

Units inside this package are the ones of Tu's constants: centimetre, gram and the *time unit*
``tu`` of 0.1 s, in which his figures describe a real fish.
"""
