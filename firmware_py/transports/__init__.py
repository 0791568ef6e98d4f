"""Ways for bytes to reach the firmware and leave it."""
