"""Work in other threads, whose results come back to the thread of the window."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple, TypeVar

Result = TypeVar("Result")
THREADS = 2


class Task(NamedTuple):
    """Work in progress."""

    future: Future[Any]
    finish: Callable[[], object]  # hands the result over; raises what the work raised
    label: str  # what is being done, in a few words; "" to show nothing


class BackgroundTasks:
    """At most two tasks at a time; `wake` is called, in another thread, when one has ended."""

    def __init__(self, wake: Callable[[], object]) -> None:
        self._pool, self._wake = ThreadPoolExecutor(THREADS, "background"), wake
        self._tasks: list[Task] = []

    def submit(
        self,
        work: Callable[[], Result],
        done: Callable[[Result], object],
        label: str,
        failed: Callable[[], object],
    ) -> None:
        """Run `work` in another thread; its task calls `done` with the result, or `failed`."""
        future = self._pool.submit(work)

        def finish() -> None:
            if future.exception() is not None:
                failed()
            done(future.result())

        self._tasks.append(Task(future, finish, label))
        future.add_done_callback(lambda _: self._wake())

    def ended(self) -> list[Task]:
        """Remove the tasks that have ended, and return them to be finished."""
        ended = [task for task in self._tasks if task.future.done()]
        self._tasks = [task for task in self._tasks if task not in ended]
        return ended

    @property
    def busy(self) -> bool:
        """True if a task has not been finished."""
        return bool(self._tasks)

    @property
    def label(self) -> str:
        """State of the first task with a label."""
        return next((task.label for task in self._tasks if task.label), "")

    def close(self) -> None:
        """Cancel what has not begun; do not wait for the rest."""
        self._pool.shutdown(wait=False, cancel_futures=True)
