"""One flight: plant, sensors, links, firmware and actuator, tick by tick, and the verdict on it."""
