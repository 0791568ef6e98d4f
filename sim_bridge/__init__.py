"""The bridge: stands in for kite, wind and radio, so that the whole stack flies without hardware."""
