"""Say in one sentence of plain words what a fish is about, for visitors."""

from subsea.base.language import marked, translated
from subsea.behavior.table import INTENTIONS
from subsea.dive.minds_text import SHUN, STAY, STRUGGLE, VIGILANT
from subsea.state import (
    AVOID,
    BATHE,
    CHEWING,
    CIRCLING,
    CLEAN,
    CURIOUS,
    EAT,
    ESCAPE,
    FEAR,
    GRAZE,
    GUARD,
    HUNGER,
    LEAVE,
    MATE,
    NOBODY,
    PICK,
    POSE,
    PREDATOR,
    RECOVERING,
    RUSHING,
    SCHOOL,
    SHELTER,
    SPAWNING,
    STALKING,
    SUBMARINE,
    WANDER,
    YIELD,
)
from subsea.world.world import World

SENTENCES = {
    AVOID: marked("It turns away from what is in its way."),
    ESCAPE: marked("It flees for its life."),
    SCHOOL: marked("It travels with its school."),
    EAT: marked("It is hungry and looks for food."),
    MATE: marked("It looks for a mate."),
    LEAVE: marked("It does not like this light or this cold, and leaves."),
    WANDER: marked("It explores the reef."),
    CURIOUS: marked("It is curious about something new."),
    STRUGGLE: marked("It struggles on the hook."),
    GRAZE: marked("It feeds on the stone."),
    BATHE: marked("It rests in its anemone."),
    GUARD: marked("It drives an intruder from its home."),
    YIELD: marked("It gives way to the owner of this place."),
    SHELTER: marked("It hides in the reef."),
    POSE: marked("It holds still and asks to be cleaned."),
    CLEAN: marked("It waits at its station for fishes to clean."),
    SHUN: marked("It keeps away from a fish that chased it."),
    STAY: marked("It stays near a fish that it likes."),
    VIGILANT[0]: marked("It has seen something and watches it."),
    VIGILANT[1]: marked("It is bold and inspects the predator."),
    PICK: marked("It picks plankton out of the water."),
}
"""By the code of the intention; those of other packages have none."""
HUNTING = {
    STALKING: marked("It stalks its prey."),
    RUSHING: marked("It rushes at its prey."),
    CHEWING: marked("It has caught a fish and eats it."),
    RECOVERING: marked("It has missed, and rests."),
}
PATROLS = marked("It patrols and looks for prey.")
SEES_YOU = marked("It is curious about you.")
CLEANS = marked("It cleans another fish.")
TIGHT = marked("It keeps close to its school: there is danger.")
COURTS, SPAWNS = marked("It courts its mate."), marked("It spawns with its mate.")
FED = marked("It is full, and swims about.")
AFRAID = 0.35  # share of fear from which a fish in a school is said to be in danger
SATED = 0.05  # hunger below which a wandering predator is full


def sentence(world: World, fish: int) -> str:
    """Say what a fish is about, in the language of visitors."""
    return translated(_words(world, fish))


def _words(world: World, fish: int) -> str:
    minds = world.state.minds
    intention = int(minds.intention[fish])
    if minds.kind[fish] == PREDATOR and intention in (EAT, WANDER):
        if int(minds.hunt[fish]) in HUNTING:
            return HUNTING[int(minds.hunt[fish])]
        return FED if minds.mental[fish, HUNGER] < SATED else PATROLS
    if intention == SCHOOL and minds.mental[fish, FEAR] > AFRAID:
        return TIGHT
    if intention == MATE and minds.partner[fish] != NOBODY:
        state = minds.courtship[fish]
        return SPAWNS if state == SPAWNING else COURTS if state >= CIRCLING else SENTENCES[MATE]
    if intention == CLEAN and minds.client[fish] != NOBODY:
        return CLEANS
    if intention == CURIOUS and minds.target[fish] == SUBMARINE:
        return SEES_YOU
    return SENTENCES.get(intention, INTENTIONS[intention])
