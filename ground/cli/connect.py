"""The session that a verb runs in."""

import argparse
import time

from ground.cli.options import link_names
from ground.cli.terminal import tell
from ground.link.links import open_links
from ground.session import Session


def open_session(args: argparse.Namespace) -> Session:
    """Open the links of `args` and wait for its vehicle. Raises LinkError or UsageError if that fails."""
    session = Session(open_links(link_names(args), time.monotonic, tell), tell, args.system)
    try:
        session.find_vehicle(args.timeout)
    except BaseException:
        session.links.close()
        raise
    return session
