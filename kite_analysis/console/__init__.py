"""Shared by both programs: answers to mistakes, plot files, optional packages."""
