"""The bridge that stands in for the kite, the wind and the radio, so that the whole stack flies without hardware."""
