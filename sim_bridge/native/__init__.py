"""The loop as machine code: what of the firmware and the bridge is compiled, by what, and which is flown."""
