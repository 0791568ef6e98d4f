"""The option --snapshot, for verbs that take a snapshot of the parameters or restore it."""

import argparse

from ground.parameters.snapshot import SnapshotStore
from ground.session import Session


def add_snapshot_option(verb: argparse.ArgumentParser) -> None:
    """Add --snapshot."""
    verb.add_argument("--snapshot", metavar="FILE", help="file of the snapshot that `param revert` restores "
                      "(default: one per kite, in the user's state folder)")


def snapshot_store(args: argparse.Namespace, session: Session) -> SnapshotStore:
    """The snapshot of the session's vehicle, in the file of --snapshot (for verbs that have it) or the default."""
    return SnapshotStore(session.parameters, session.notice, getattr(args, "snapshot", None), args.wall_clock)
