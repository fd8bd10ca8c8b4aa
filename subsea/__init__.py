"""A virtual submarine among artificial fishes."""

import os

# Read by numba when it is first imported.
os.environ.setdefault(
    "NUMBA_CACHE_LOCATOR_CLASSES",
    "subsea.core.kernels.cache.Provided,subsea.core.kernels.cache.InTree,subsea.core.kernels.cache.UserWide,"
    "IPythonCacheLocator,ZipCacheLocator",
)
