"""The contract between kite and ground: the MAVLink dialect, the parameter table, and what is generated from them."""
