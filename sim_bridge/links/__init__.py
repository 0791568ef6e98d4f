"""Links: emulated radio links, the bridge's codec, sockets and ports to ground stations and boards."""
