"""Studies of many flights: the paper's figures, real flights, what the plants are worth."""
