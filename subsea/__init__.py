"""A virtual submarine among artificial fishes."""

import os

# Read by numba when it is first imported.
os.environ.setdefault(
    "NUMBA_CACHE_LOCATOR_CLASSES",
    "subsea.caching.Provided,subsea.caching.InTree,subsea.caching.UserWide,"
    "IPythonCacheLocator,ZipCacheLocator",
)
