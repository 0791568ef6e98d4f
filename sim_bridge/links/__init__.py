"""The radio: emulated links, the bridge's end of the wire, the way to ground stations and boards."""
