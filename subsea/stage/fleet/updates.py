"""A node's side of an update: takes a wheel, installs it beside the running version, switches."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import BinaryIO

from subsea import __version__
from subsea.base.errors import UserError
from subsea.stage.fleet import installing
from subsea.stage.fleet.installing import LinkedEnvironment, missing_packages
from subsea.stage.fleet.messages import (
    Answer,
    Install,
    Rollback,
    Switch,
    UpdateOrder,
    WheelOffer,
    WheelPart,
)
from subsea.stage.fleet.wheel import read_wheel

INCOMING = ".incoming"  # a folder for the wheel, beside the link


class Updates:
    """Follows the orders of an update; what takes long runs in a thread.

    Every order gets an answer. A fault is an answer, too, and changes nothing.
    """

    def __init__(
        self, find: Callable[[], LinkedEnvironment] = installing.running_installation
    ) -> None:
        """`find` returns the environment to replace, or raises a UserError."""
        self.restarts = False  # True if this computer is to start again, its last answer is taken
        self._find = find
        self._thread = ThreadPoolExecutor(1, "update")
        self._under_way: Future[Answer] | None = None
        self._answers: list[Answer] = []
        self._offer: WheelOffer | None = None
        self._file: BinaryIO | None = None
        self._path = Path()
        self._installed: Path | None = None
        self._switched = False  # the link leads to another version

    def hear(self, order: UpdateOrder) -> None:
        """Take an order."""
        name = str(order.__struct_config__.tag)
        try:
            if self._under_way is not None:
                raise UserError("another order is under way")
            match order:
                case WheelOffer():
                    self._answers.append(self._take_offer(order))
                case WheelPart():
                    self._answers.append(self._take_part(order))
                case Install():
                    self._under_way = self._thread.submit(self._answered, name, self._install)
                case Switch():
                    self._under_way = self._thread.submit(self._answered, name, self._switch)
                case Rollback(only_check):
                    back = self._check_back if only_check else self._roll_back
                    self._under_way = self._thread.submit(self._answered, name, back)
        except (UserError, OSError) as fault:
            self._answers.append(Answer(name, False, str(fault)[:1000]))

    def take_answers(self) -> list[Answer]:
        """Take the answers that are ready."""
        if self._under_way is not None and self._under_way.done():
            self._answers.append(self._under_way.result())
            self._under_way, self.restarts = None, self._switched
        answers, self._answers = self._answers, []
        return answers

    def close(self) -> None:
        """Begin no more work, and close a wheel that is not complete."""
        self._thread.shutdown(wait=False, cancel_futures=True)
        if self._file is not None:
            self._file.close()

    def _take_offer(self, offer: WheelOffer) -> Answer:
        """Begin to take a wheel, if it can be installed here."""
        place = self._find()
        if missing := missing_packages(offer.requires):
            raise UserError(missing)
        if self._file is not None:
            self._file.close()
        folder = place.link.parent / INCOMING
        folder.mkdir(mode=0o700, exist_ok=True)
        for old in folder.glob("*.whl"):
            old.unlink()
        self._path = folder / offer.wheel
        self._file, self._offer, self._installed = self._path.open("wb"), offer, None
        return Answer("offer", True, __version__)

    def _take_part(self, part: WheelPart) -> Answer:
        offer, file = self._offer, self._file
        if offer is None or file is None or part.offset != file.tell():
            raise UserError("this part of a wheel does not follow what was received")
        file.write(part.data)
        if file.tell() >= offer.size:
            file.close()
            self._file = None
        return Answer("wheel", True, offset=part.offset + len(part.data))

    def _answered(self, name: str, work: Callable[[], str]) -> Answer:
        """The answer to an order that takes long; runs in the thread."""
        try:
            return Answer(name, True, work())
        except (UserError, OSError) as fault:
            return Answer(name, False, str(fault)[:1000])

    def _install(self) -> str:
        offer = self._offer
        if offer is None or self._file is not None:
            raise UserError("no whole wheel was received")
        wheel = read_wheel(self._path)
        if (wheel.digest, wheel.version) != (offer.digest, offer.version):
            raise UserError("the wheel received is not the one that was offered")
        if missing := missing_packages(wheel.requires):
            raise UserError(missing)
        place = self._find()
        installing.remove_old(place)
        self._installed = installing.install(wheel, place)
        self._path.unlink()
        return wheel.version

    def _switch(self) -> str:
        if self._installed is None or self._offer is None:
            raise UserError("no version is installed to switch to")
        installing.switch(self._find(), self._installed)
        self._installed, self._switched = None, True
        return self._offer.version

    def _check_back(self) -> str:
        return installing.version_before(self._find())

    def _roll_back(self) -> str:
        place = self._find()
        version = installing.version_before(place)
        installing.roll_back(place)
        self._switched = True
        return version
