from subsea.base.errors import UserError as UserError
from subsea.behavior.teleop import TeleopCommand as TeleopCommand
from subsea.behavior.teleop import TeleopCommands as TeleopCommands
from subsea.lab.dataset.labelling import Labels as Labels
from subsea.lab.dataset.labelling import labels as labels
from subsea.lab.designs import latin_hypercube as latin_hypercube
from subsea.lab.designs import sobol as sobol
from subsea.lab.environments import predator_prey as predator_prey
from subsea.lab.environments import school as school
from subsea.lab.records import measure as measure
from subsea.lab.records import open_record as open_record
from subsea.lab.records import record as record
from subsea.lab.records import scenarios as scenarios
from subsea.lab.records import simulate as simulate
from subsea.lab.records import species as species
from subsea.lab.records import sweep as sweep
from subsea.lab.rules import rule as rule
from subsea.lab.rules import sense as sense
from subsea.library import Retina as Retina
from subsea.library import World as World
from subsea.library import behind as behind
from subsea.library import camera as camera
from subsea.library import load as load
from subsea.library import render as render
from subsea.library import retina as retina
from subsea.media.record import Record as Record
from subsea.submarine.vessel import Helm as Helm
from subsea.view.optics import CameraLens as CameraLens
from subsea.view.optics import FlatPort as FlatPort

__version__: str
_PLACES: dict[str, str]
__all__: list[str]
