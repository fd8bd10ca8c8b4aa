"""Parameters of a tick: its time, and constants that a scenario or a panel may change."""

from typing import NamedTuple


class Nature(NamedTuple):
    """Constants of perception and behavior (Tu chs. 6, 7)."""

    vision_cm: float  # V_r for an object of standard size
    smell_cm: float  # O_r
    standard_cm: float  # length of a fish of standard size, s^p = 1
    hunger_stimulus: float  # alpha_h
    libido_stimulus: float  # alpha_l
    alarmed: float  # f0: fear above this calls for evasion
    panicked: float  # f1: fear of one predator from which the fish flees
    keen: float  # r: hunger or libido above this calls for eating or mating
    devotion_cm: float  # how much nearer another target must be to be preferred (Tu §7.7.3)
    fatigue_s: float  # time after which a desire has dropped to half (Tu §7.7.2)
    timidity: float  # factor on the collision sensitivity region (Tu §6.6.1)
    submarine_cm: float  # D0 of the submarine for prey: the size of predator that it appears
    curiosity_cm: float  # distance from which the submarine attracts pacifists, 0 for never


class Physics(NamedTuple):
    """Differences of simulated fishes from the recorded ones (Tu §9.2)."""

    unit_mass: float = 1.0  # factor on the mass of every node
    viscosity: float = 1.0  # factor on kappa of every unit
    stiffness: float = 1.0  # factor on the spring constant of every unit
    water_viscosity: float = 1.0  # factor on mu of Tu eq. 4.3, and on the push of the fins
    hydrodynamics: bool = True  # False: no forces of the water
    time_step: float = 1.0  # factor on the 5.5 ms of Tu §4.5.2
    iterations: int = 6  # steps in a tick; 6 keep pace with played-back fishes
    fish: int = -1  # fish that is always simulated first, -1 for none


class Clock(NamedTuple):
    """Time of a tick, and key of its random numbers."""

    seed: int
    tick: int
    dt: float  # s
