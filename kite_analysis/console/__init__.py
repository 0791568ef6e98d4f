"""Shared by both command lines: answers to mistakes, plot files, optional packages."""
