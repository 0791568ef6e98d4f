"""Transports: how bytes reach and leave the firmware."""
