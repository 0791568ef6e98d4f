"""The firmware's MAVLink: generated tables, checksum, decoder, encoder, and the one link with its budget."""
