"""The keys with which a computer takes part in the dive of a theatre's cluster."""

from collections.abc import Sequence
from pathlib import Path

from subsea.core.errors import UserError
from subsea.core.toml_files import error_at
from subsea.dive.cluster.keys import SECRET, Keys, read_keys
from subsea.dive.cluster.link import endpoint
from subsea.view.theatre.theatre_file import Cluster


def credentials(cluster: Cluster, nodes: Sequence[str], node: str, path: Path) -> Keys | None:
    """The keys of one of a cluster's `nodes`, if the theatre file `path` names any.

    Keys that are missing and an address that needs some are UserErrors.
    """
    try:
        keys = None
        if cluster.keys is not None:
            others = [name for name in nodes if name != node]
            known = others if node == cluster.master else [cluster.master]
            keys = read_keys(path.parent / cluster.keys, node, known)
        endpoint(cluster.address, keys)
    except UserError as fault:
        raise error_at(path, "cluster", f"[cluster]: {fault}") from fault
    return keys


def cluster_faults(cluster: Cluster, nodes: Sequence[str], path: Path) -> tuple[UserError, ...]:
    """An error for each node whose secret key is here and that cannot take part all the same.

    A computer needs no secret key but its own; where there is none at all the master's is missing.
    """
    here = [cluster.master]
    if cluster.keys is not None:
        folder = path.parent / cluster.keys
        here = [node for node in nodes if (folder / f"{node}{SECRET}").exists()] or here
    faults = []
    for node in here:
        try:
            credentials(cluster, nodes, node, path)
        except UserError as fault:
            faults.append(fault)
    return tuple(faults)
