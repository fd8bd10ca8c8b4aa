from subsea.behavior.teleop import TeleopCommand as TeleopCommand
from subsea.behavior.teleop import TeleopCommands as TeleopCommands
from subsea.core.errors import UserError as UserError
from subsea.environments import predator_prey as predator_prey
from subsea.environments import school as school
from subsea.library.pictures import Retina as Retina
from subsea.library.pictures import behind as behind
from subsea.library.pictures import camera as camera
from subsea.library.pictures import render as render
from subsea.library.pictures import retina as retina
from subsea.library.records import measure as measure
from subsea.library.records import open_record as open_record
from subsea.library.records import scenarios as scenarios
from subsea.library.records import simulate as simulate
from subsea.library.records import species as species
from subsea.library.records import sweep as sweep
from subsea.library.world import World as World
from subsea.library.world import load as load
from subsea.study.record import Record as Record
from subsea.submarine.helm import Helm as Helm

__version__: str
_PLACES: dict[str, str]
__all__: list[str]
