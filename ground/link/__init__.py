"""A MAVLink conversation with one vehicle: transports, links that reconnect, statistics, time-outs."""
