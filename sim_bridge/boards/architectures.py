"""The platforms that the firmware runs on."""

ARCHITECTURES = {"rp2": "armv6m", "esp32": "xtensawin"}  # of native code; armv6m runs on every Pico
