"""The keys of a computer in the cluster of a theatre."""

from collections.abc import Sequence
from pathlib import Path

from subsea.base.errors import UserError
from subsea.base.toml_files import error_at
from subsea.stage.cluster.keys import SECRET, Keys, read_keys
from subsea.stage.cluster.link import endpoint
from subsea.stage.theatre.theatre_file import Cluster


def credentials(cluster: Cluster, nodes: Sequence[str], node: str, path: Path) -> Keys | None:
    """Read the keys of `node`, if the theatre file `path` names a folder of keys.

    Missing keys, and an address that needs keys where none are named, are UserErrors.
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
    """Errors of the nodes that have a secret key on this computer; of the master if none has.

    A computer needs no secret key but its own.
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
