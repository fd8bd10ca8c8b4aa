import pytest

from capture.flat.lessons import Effort, FlatLearner
from capture.flat.scaffold import read_scaffold


@pytest.fixture(scope="session")
def body():
    return read_scaffold()


@pytest.fixture(scope="session")
def learner(body):
    """Lessons that take a second or two."""
    return FlatLearner(body, Effort(1, 60, 1, 40, 3, 1, 2))
