"""Shared by both programs: their verbs, answers to mistakes, optional packages."""
