"""What the models are worth: the law on real flights and on every plant, in tables made by one command."""
