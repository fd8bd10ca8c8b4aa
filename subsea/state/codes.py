"""Codes and column numbers that arrays of the state hold."""

import numpy as np

NEIGHBOURS = 7  # companions that a fish attends to
CHOICES = 3  # targets among which it chooses: K of Tu §6.5.3
FEELINGS = 4  # others for whom it has a feeling
NOBODY, SUBMARINE = -1, -2  # in place of the index of a fish
BAIT = -3  # target of a plankton eater that is after the bait instead of a speck
ANYONE = np.array([0, 2**31 - 1, -1], np.int32)  # row of `Minds.quarry` that allows every prey
HULL_CM = 45.0  # radius of the submarine, with some margin

KINDS = ("pacifist", "prey", "predator")  # Tu §7.9
PACIFIST, PREY, PREDATOR = range(3)

# Intentions (Tu fig. 7.4); `behavior/table.py` has the behavior of each.
AVOID, ESCAPE, SCHOOL, EAT, MATE, LEAVE, WANDER, CURIOUS = range(8)
# Those of a life on stone are rows of the same table.
GRAZE, BATHE, GUARD, YIELD, SHELTER, POSE, CLEAN = range(9, 16)
PICK = 20  # of plankton, in a school

# Places that fishes look for on stone and among corals (`habitat/sites.py`); foods come first.
SITES = ("turf", "polyps", "sponges", "rubble", "anemone", "shelter")
TURF, POLYPS, SPONGES, RUBBLE, ANEMONE, COVER = range(6)
# Bits of `Minds.ways`: hides in crevices and corals, bathes in an anemone, cleans others.
HIDES, BATHES, CLEANS = 1, 2, 4
FOODS = 4  # kinds of sites to feed at; bits of `Minds.diet`

# Columns of `Minds.likes`: habits (Tu §7.3).
BRIGHTNESS, DARKNESS, COLD, WARMTH = range(4)
# Columns of `Minds.mental`.
MENTAL_STATES = ("hunger", "libido", "fear")
HUNGER, LIBIDO, FEAR = range(3)
# Columns of `Minds.preference`: motor preferences (Tu §6.5.2).
LEFT, RIGHT, FORWARD, BACKWARD, ASCEND, DESCEND = range(6)
# Barriers that are not solids; pillars count from 0, rocks follow the pillars, -1 means none.
SEABED, SURFACE, WALL = -2, -3, -4
# States of a courtship (Tu §7.9.3).
COURTSHIP = ("none", "approaching", "looping", "circling", "ascending", "nuzzling", "spawning")
NO_COURTSHIP, APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING, SPAWNING = range(7)

# Phases of a predator's hunt.
HUNT = ("patrolling", "stalking", "rushing", "chewing", "recovering")
PATROLLING, STALKING, RUSHING, CHEWING, RECOVERING = range(5)

# Channels of `Odour.amount` and columns of `Minds.scent`: bait, blood, and the alarm substance of
# wounded skin.
ODOURS = ("food", "blood", "alarm")
BAIT_ODOUR, BLOOD, ALARM = range(3)

# States of the hook (Tu §10.1).
STOWED, SINKING, HANGING, HOOKED, LANDED = range(5)

# Columns of `Fishes.fins`, in the order of the instance record.
SWEEP_LEFT, SWEEP_RIGHT = 0, 1  # rad, of a pectoral fin away from the body
LIFT_LEFT, LIFT_RIGHT = 2, 3  # rad, of a pectoral fin above its rest
MOUTH = 4  # 0 shut to 1 open
DORSAL = 5  # 0 folded to 1 erect, above 1 raised: spines of the dorsal and ventral fin
TAIL = 6  # how much wider than at rest the tail is spread; below 0 it is closed
SOFT = 7  # as DORSAL, of the soft rays behind the spines
# Wave of the dorsal and ventral fin: amplitude, over the height, times sine and cosine of its
# phase at the front. So both are continuous, and may be interpolated.
WAVE_SINE, WAVE_COSINE = 8, 9
PELVIC = 10  # 0 folded to the belly to 1 spread
TWIST_LEFT, TWIST_RIGHT = 11, 12  # rad, by which the upper edge of a pectoral fin is turned ahead
LAG = 13  # of the tail's edge to the right, over the length of the tail
FIN_COLUMNS = 14
FINS_AT_EASE = (0.35, 0.35, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.0)
