"""The options of the verbs: a file for each group. Nothing here, and nothing that it imports, flies."""
