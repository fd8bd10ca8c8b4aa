"""Every array that changes. One fish is one index in [0, n).

Arrays are plain numpy, so that any kernel accepts them.
`docs/reference/state.md` lists all of them.
"""

from subsea.state.codes import *  # noqa: F403
from subsea.state.declaration import Spec as Spec
from subsea.state.declaration import declared as declared
from subsea.state.declaration import empty as empty
from subsea.state.groups import GROUPS as GROUPS
from subsea.state.groups import TRAITS as TRAITS
from subsea.state.groups import Clock as Clock
from subsea.state.groups import Directions as Directions
from subsea.state.groups import Fishes as Fishes
from subsea.state.groups import Live as Live
from subsea.state.groups import Minds as Minds
from subsea.state.groups import Nature as Nature
from subsea.state.groups import Odour as Odour
from subsea.state.groups import Physics as Physics
from subsea.state.groups import Reef as Reef
from subsea.state.groups import Sea as Sea
from subsea.state.groups import Seaweed as Seaweed
from subsea.state.groups import State as State
from subsea.state.groups import Submarine as Submarine
from subsea.state.groups import arrays as arrays
